// The study tab: one or two fields varied, a curve or a map, with progress and cancel.
import * as api from "./api.js";
import { at } from "./cases.js";
import { newCurve, newPanel } from "./chart.js";
import { QuantityBox } from "./quantity.js";
import { OnePanel } from "./results.js";
import { csvColumn, csvOf, save } from "./exchange.js";
import { html, useState } from "./html.js";
import { ValueMap } from "./plane.js";
import { RunButtons, runStudy, StudyState } from "./progress.js";
import { symbolText } from "./symbols.js";
import { T } from "./texts.js";
import { digits } from "./units.js";
import { defaultVariable, labelOf, outputsOf, variables } from "./variables.js";

/** Where a field's study begins and ends unless somebody says otherwise: around its value. */
function around({ field, value }) {
  const [low, high] = field.typical ?? [0.5 * value, 1.5 * value];
  const ends = value > 0 ? [Math.max(Math.min(low, value), 0.5 * value), Math.min(Math.max(high, value), 1.5 * value)] : [low, high];
  return ends.map((end) => Number(end.toPrecision(3)));
}

export function Study({ store }) {
  const { state, kind, catalogue } = store;
  const fields = variables(store);
  const outputs = kind.outputs.filter((output) => !output.array && !output.whole);
  const [plan, setPlan] = useState({ first: "", second: "", count: 21, across: 9, output: "", ends: {} });
  const study = state.study?.kind === kind.name ? state.study : null;
  const output = outputs.some((one) => one.name === plan.output) ? plan.output : (outputsOf(store)[0] ?? outputs[0])?.name;
  const field = (path) => fields.find((one) => one.path === path);
  const first = field(plan.first) ?? defaultVariable(store, fields);
  const second = fields.find((one) => one.path === plan.second && one.path !== first.path);
  const endsOf = (one) => plan.ends[one.path] ?? around(one);
  const cases = plan.count * (second ? plan.across : 1);
  const most = catalogue.limits.sweep_cases;
  const axis = (one, count) => ({ from: endsOf(one)[0], to: endsOf(one)[1], count });
  const good = (one) => { const [a, b] = endsOf(one); return Number.isFinite(a) && Number.isFinite(b) && a !== b; };
  const ready = [first, second].filter(Boolean).every(good) && cases <= most && plan.count >= 2;

  const run = () => {
    const over = { [first.path]: axis(first, plan.count), ...(second ? { [second.path]: axis(second, plan.across) } : {}) };
    const wanted = [...new Set([...kind.main, ...outputs.filter((one) => one.unit === "N/m" || one.name === output).map((one) => one.name)])].slice(0, 12);
    const body = { case: state.case, over, outputs: wanted };
    return runStudy(store, "study", (handle, signal) => api.sweep(body, handle, signal), takeCases);
  };

  return html`<section class="tab-card"><h2>${T.study.title}</h2>
    <div class="study-form">
      <${Axis} ...${{ store, name: "first", label: T.study.first, fields, chosen: first, ends: endsOf(first), count: plan.count,
        pick: (path) => setPlan({ ...plan, first: path }), setEnds: (ends) => setPlan({ ...plan, ends: { ...plan.ends, [first.path]: ends } }), setCount: (count) => setPlan({ ...plan, count }) }} />
      <${Axis} ...${{ store, name: "second", label: T.study.second, fields: fields.filter((one) => one !== first), chosen: second, optional: true, ends: second && endsOf(second), count: plan.across,
        pick: (path) => setPlan({ ...plan, second: path }), setEnds: (ends) => setPlan({ ...plan, ends: { ...plan.ends, [second.path]: ends } }), setCount: (across) => setPlan({ ...plan, across }) }} />
      <div class="axis-row"><label class="stacked">${T.study.output}<select id="study-output" value=${output} onChange=${(event) => setPlan({ ...plan, output: event.target.value })}>
        ${outputs.map((one) => html`<option value=${one.name} selected=${one.name === output}>${one.label} (${symbolText(one.symbol)})</option>`)}</select></label>
        <${RunButtons} ...${{ name: "study", study, words: T.study.run, ready, run }}>${cases > most && html`<span class="fault" role="alert">${T.study.tooMany(most)}</span>`}<//></div>
    </div>
    <${StudyState} ...${{ store, study, words: study && T.study.progress(study.done, study.of) }}>
      ${study?.failures?.some(Boolean) && html`<span class="fault" title=${study.failures.find(Boolean)}>${T.study.failed(study.failures.filter(Boolean).length)}: ${study.failures.find(Boolean)}</span>`}<//>
  </section>
  ${study?.inputs ? html`<${Outcome} ...${{ store, study, output }} />` : html`<p class="quiet">${T.study.empty}</p>`}`;
}

/** What an event of a sweep adds to the outcome of the study. */
function takeCases(event, { values, failures }) {
  if (event.event === "started") {
    const columns = Object.fromEntries(event.outputs.map((name) => [name, Array(event.cases).fill(null)]));
    return { of: event.cases, inputs: event.inputs, values: columns, failures: Array(event.cases).fill("") };
  }
  if (event.event === "done") return { text: T.study.done(digits(event.seconds, 2)) };
  event.numbers.forEach((number, k) => {
    for (const name of Object.keys(event.values)) values[name][number] = event.values[name][k];
    failures[number] = event.failures[k];
  });
  return { done: event.done, of: event.of };
}

/** An end of the range of a field; NaN if what is typed has no value. */
export function End({ store, id, words, field, value, put }) {
  const take = (si) => { put(si ?? NaN); return si ?? NaN; };
  const unit = field && store.units.text(field);
  return html`<label class="stacked small">${words} ${unit ? `[${unit}]` : ""}
    <${QuantityBox} ...${{ store, quantity: field, value, put: take, id, disabled: !field }} /></label>`;
}

function Axis({ store, name, label, fields, chosen, optional, ends, count, pick, setEnds, setCount }) {
  const box = (k, words) => html`<${End} ...${{ store, id: `study-${name}-${k}`, words, field: chosen?.field, value: ends?.[k], put: (value) => setEnds(ends.map((end, n) => (n === k ? value : end))) }} />`;
  const wrong = chosen && !(Number.isFinite(ends[0]) && Number.isFinite(ends[1]) && ends[0] !== ends[1]);
  return html`<div class="axis-row">
    <label class="stacked">${label}<select id=${`study-${name}`} value=${chosen?.path ?? ""} onChange=${(event) => pick(event.target.value)}>
      ${optional && html`<option value="" selected=${!chosen}>${T.study.none}</option>`}
      ${fields.map((one) => html`<option value=${one.path} selected=${one.path === chosen?.path}>${labelOf(one)}</option>`)}</select></label>
    ${box(0, T.study.from)}${box(1, T.study.to)}
    <label class="stacked small">${T.study.points}<input type="number" min="2" max="200" id=${`study-${name}-count`} value=${count} disabled=${!chosen}
      onChange=${(event) => setCount(Math.max(2, Math.min(200, Math.round(Number(event.target.value)) || 2)))} /></label>
    ${wrong && html`<p class="fault" role="alert">${T.study.needs}</p>`}
  </div>`;
}

function Outcome({ store, study, output }) {
  const { units } = store;
  const name = output in study.values ? output : Object.keys(study.values)[0];
  const quantity = store.output(name);
  const [x, y] = Object.entries(study.inputs).map(([path, values]) => ({ path, field: store.fieldAt(path) ?? { label: path, unit: "1" }, values }));
  const rows = y?.values.length ?? 1; // of the second field, for each value of the first
  const download = () => {
    const column = ({ path, field }, values) => csvColumn(units, path, field, values);
    const inputs = [column(x, study.failures.map((_, k) => x.values[Math.floor(k / rows)])), ...(y ? [column(y, study.failures.map((_, k) => y.values[k % rows]))] : [])];
    const outputs = Object.entries(study.values).map(([one, values]) => csvColumn(units, one, store.output(one), values));
    save(new Blob([csvOf([...inputs, ...outputs])], { type: "text/csv" }), "study.csv");
  };
  return html`<div class="study-outcome">
    ${y ? html`<${ValueMap} ...${{ store, x, y, values: study.values[name], quantity }} />`
    : html`<div class="panel-cell"><${OnePanel} store=${store} name="study" title=${quantity.label} height=${380} cases=${[{ label: "", colour: null, panel: curvePanel(store, x, study, name, quantity) }]} /></div>`}
    <button type="button" onClick=${download}>${T.study.save}</button></div>`;
}

function curvePanel(store, x, study, name, quantity) {
  const [low, high] = [Math.min(...x.values), Math.max(...x.values)];
  const now = at(store.state.case, x.path);
  return newPanel({
    name: "study", x: { label: x.field.label, quantity: x.field, limits: [low, high] }, y: { label: quantity.label, quantity },
    marks: typeof now === "number" && now > low && now < high ? [{ along: "y", value: now, label: "" }] : [],
    curves: [newCurve({ name, symbol: quantity.symbol, x: x.values, y: study.values[name] })],
  });
}
