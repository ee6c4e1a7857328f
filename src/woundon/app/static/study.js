// The study tab: one or two fields varied, a curve or a map, with progress and cancel.
import * as api from "./api.js";
import { at } from "./cases.js";
import { QuantityBox } from "./quantity.js";
import { OnePanel } from "./results.js";
import { html, useEffect, useLayoutEffect, useRef, useState } from "./html.js";
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
  const abort = useRef(null);
  useEffect(() => () => abort.current?.abort(), []);
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

  const run = async () => {
    abort.current?.abort();
    abort.current = new AbortController();
    const { signal } = abort.current;
    const over = { [first.path]: axis(first, plan.count), ...(second ? { [second.path]: axis(second, plan.across) } : {}) };
    const outcome = { kind: kind.name, paths: Object.keys(over), values: {}, failures: [], done: 0, of: cases, running: true, text: "" };
    store.set({ study: outcome });
    const put = (more) => { Object.assign(outcome, more); store.set({ study: { ...outcome } }); };
    const wanted = [...new Set([...kind.main, ...outputs.filter((one) => one.unit === "N/m" || one.name === output).map((one) => one.name)])].slice(0, 12);
    try {
      await api.sweep({ case: state.case, over, outputs: wanted }, (event) => {
        if (event.event === "started") {
          put({ inputs: event.inputs, values: Object.fromEntries(event.outputs.map((name) => [name, Array(event.cases).fill(null)])), failures: Array(event.cases).fill("") });
        } else if (event.event === "cases") {
          event.numbers.forEach((number, k) => {
            for (const [name, values] of Object.entries(event.values)) outcome.values[name][number] = values[k];
            outcome.failures[number] = event.failures[k];
          });
          put({ done: event.done, of: event.of });
        } else if (event.event === "done") put({ running: false, text: T.study.done(digits(event.seconds, 2)) });
        else if (event.event === "cancelled") put({ running: false, text: T.study.cancelled });
      }, signal);
    } catch (fault) {
      if (fault.name === "AbortError") put({ running: false, text: T.study.cancelled });
      else put({ running: false, fault });
    }
    if (outcome.running) put({ running: false });
  };

  return html`<section class="tab-card"><h2>${T.study.title}</h2>
    <div class="study-form">
      <${Axis} ...${{ store, name: "first", label: T.study.first, fields, chosen: first, ends: endsOf(first), count: plan.count,
        pick: (path) => setPlan({ ...plan, first: path }), setEnds: (ends) => setPlan({ ...plan, ends: { ...plan.ends, [first.path]: ends } }), setCount: (count) => setPlan({ ...plan, count }) }} />
      <${Axis} ...${{ store, name: "second", label: T.study.second, fields: fields.filter((one) => one !== first), chosen: second, optional: true, ends: second && endsOf(second), count: plan.across,
        pick: (path) => setPlan({ ...plan, second: path }), setEnds: (ends) => setPlan({ ...plan, ends: { ...plan.ends, [second.path]: ends } }), setCount: (across) => setPlan({ ...plan, across }) }} />
      <div class="axis-row"><label class="stacked">${T.study.output}<select id="study-output" value=${output} onChange=${(event) => setPlan({ ...plan, output: event.target.value })}>
        ${outputs.map((one) => html`<option value=${one.name} selected=${one.name === output}>${one.label} (${symbolText(one.symbol)})</option>`)}</select></label>
        <div class="study-run">
          <button type="button" class="primary" id="study-run" disabled=${!ready || study?.running} onClick=${run}>${T.study.run}</button>
          <button type="button" id="study-cancel" disabled=${!study?.running} onClick=${() => abort.current?.abort()}>${T.study.cancel}</button>
          ${cases > most && html`<span class="fault" role="alert">${T.study.tooMany(most)}</span>`}
        </div></div>
    </div>
    ${study && html`<div class="study-state" role="status">
      <progress max=${study.of} value=${study.done} aria-label=${T.study.progress(study.done, study.of)}></progress>
      <span id="study-progress">${T.study.progress(study.done, study.of)}</span> <b>${study.text}</b>
      ${study.failures.some(Boolean) && html`<span class="fault" title=${study.failures.find(Boolean)}>${T.study.failed(study.failures.filter(Boolean).length)}: ${study.failures.find(Boolean)}</span>`}
      ${study.fault && html`<span class="fault" role="alert">${store.textOf(study.fault)}</span>`}</div>`}
  </section>
  ${study?.inputs ? html`<${Outcome} ...${{ store, study, output }} />` : html`<p class="quiet">${T.study.empty}</p>`}`;
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
  const name = output in study.values ? output : Object.keys(study.values)[0];
  const quantity = store.output(name);
  const [first, second] = study.paths;
  const x = { path: first, field: store.fieldAt(first) ?? { label: first, unit: "1" }, values: study.inputs[first] };
  const csv = () => {
    const { units } = store;
    const heads = [...study.paths.map((path) => units.label(path, store.fieldAt(path) ?? { unit: "1" })), ...Object.keys(study.values).map((one) => units.label(one, store.output(one)))];
    const n2 = second ? study.inputs[second].length : 1;
    const rows = study.failures.map((_, k) => [
      units.shown(x.field, x.values[Math.floor(k / n2)]), ...(second ? [units.shown(store.fieldAt(second), study.inputs[second][k % n2])] : []),
      ...Object.entries(study.values).map(([one, values]) => units.shown(store.output(one), values[k]) ?? ""),
    ].map((value) => (value === "" ? "" : Number(value.toPrecision(9)))).join(","));
    const blob = new Blob([`${[heads.join(","), ...rows].join("\n")}\n`], { type: "text/csv" });
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = "study.csv";
    link.click();
  };
  return html`<div class="study-outcome">
    ${second ? html`<${Map2} ...${{ store, x, y: { path: second, field: store.fieldAt(second), values: study.inputs[second] }, values: study.values[name], quantity }} />`
    : html`<div class="panel-cell"><${OnePanel} store=${store} name="study" title=${quantity.label} height=${380} cases=${[{ label: "", colour: null, panel: curvePanel(store, x, study, name, quantity) }]} /></div>`}
    <button type="button" onClick=${csv}>${T.study.save}</button></div>`;
}

function curvePanel(store, x, study, name, quantity) {
  const [low, high] = [Math.min(...x.values), Math.max(...x.values)];
  const now = at(store.state.case, x.path);
  return {
    name: "study", column: "study", x: { label: x.field.label, quantity: x.field, range: [low, high] }, y: { label: quantity.label, quantity }, areas: [],
    marks: typeof now === "number" && now > low && now < high ? [{ along: "y", value: now, label: "" }] : [],
    curves: [{ name, symbol: quantity.symbol, label: "", role: "roll", dash: "solid", side: "left", x: x.values, y: study.values[name] }],
  };
}

// ---- a map: light to dark, with values; the value under the pointer is shown ----

const RAMP = [[253, 231, 37], [122, 209, 81], [34, 168, 132], [42, 120, 142], [65, 68, 135], [68, 1, 84]]; // viridis, turned

function coloured(share) {
  const place = Math.min(RAMP.length - 1.0001, Math.max(0, share) * (RAMP.length - 1));
  const k = Math.floor(place);
  return RAMP[k].map((from, i) => Math.round(from + (RAMP[k + 1][i] - from) * (place - k)));
}

/** A map of an output; `note(i, j)` adds a text to the value under the pointer. */
export function Map2({ store, x, y, values, quantity, note = () => "", range = null }) {
  const { units } = store;
  const canvas = useRef(null);
  const [shown, show] = useState("");
  const known = values.filter((value) => value != null).map((value) => units.shown(quantity, value));
  const [low, high] = range ?? (known.length ? [Math.min(...known), Math.max(...known)] : [0, 1]);
  const [nx, ny] = [x.values.length, y.values.length];
  const room = { left: 66, right: 14, top: 10, bottom: 44 };
  const height = 420;
  const text = (field, value) => digits(units.shown(field, value), 4);
  const draw = () => {
    const place = canvas.current;
    if (!place) return;
    const width = place.clientWidth;
    place.width = width * devicePixelRatio;
    place.height = height * devicePixelRatio;
    const ctx = place.getContext("2d");
    ctx.scale(devicePixelRatio, devicePixelRatio);
    const style = getComputedStyle(place);
    const [w, h] = [(width - room.left - room.right) / nx, (height - room.top - room.bottom) / ny];
    const ink = style.color;
    ctx.font = "11px system-ui, sans-serif";
    for (let i = 0; i < nx; i++) {
      for (let j = 0; j < ny; j++) {
        const value = units.shown(quantity, values[i * ny + j]);
        const [px, py] = [room.left + i * w, room.top + (ny - 1 - j) * h];
        if (value == null) {
          ctx.strokeStyle = ink;
          ctx.globalAlpha = 0.25;
          ctx.strokeRect(px + 1, py + 1, w - 2, h - 2);
          ctx.globalAlpha = 1;
          continue;
        }
        const rgb = coloured((value - low) / (high - low || 1));
        ctx.fillStyle = `rgb(${rgb})`;
        ctx.fillRect(px, py, w + 0.6, h + 0.6);
        const words = digits(value, 3);
        if (w > ctx.measureText(words).width + 6 && h > 14) {
          ctx.fillStyle = 0.3 * rgb[0] + 0.59 * rgb[1] + 0.11 * rgb[2] > 130 ? "#111" : "#fff";
          ctx.textAlign = "center";
          ctx.textBaseline = "middle";
          ctx.fillText(words, px + w / 2, py + h / 2);
        }
      }
    }
    ctx.fillStyle = ink;
    ctx.textBaseline = "top";
    ctx.textAlign = "center";
    const every = (n, size, wide) => Math.max(1, Math.ceil(wide / size));
    for (let i = 0; i < nx; i += every(nx, w, 54)) ctx.fillText(text(x.field, x.values[i]), room.left + (i + 0.5) * w, height - room.bottom + 6);
    ctx.font = "600 11px system-ui, sans-serif";
    ctx.fillText(units.label(x.field.label, x.field), room.left + (nx * w) / 2, height - 16);
    ctx.font = "11px system-ui, sans-serif";
    ctx.textAlign = "right";
    ctx.textBaseline = "middle";
    for (let j = 0; j < ny; j += every(ny, h, 16)) ctx.fillText(text(y.field, y.values[j]), room.left - 6, room.top + (ny - j - 0.5) * h);
    ctx.save();
    ctx.translate(10, room.top + (ny * h) / 2);
    ctx.rotate(-Math.PI / 2);
    ctx.textAlign = "center";
    ctx.font = "600 11px system-ui, sans-serif";
    ctx.fillText(units.label(y.field.label, y.field), 0, 0);
    ctx.restore();
  };
  const redraw = useRef(draw);
  redraw.current = draw;
  useLayoutEffect(draw);
  useEffect(() => {
    const watch = new ResizeObserver(() => redraw.current());
    watch.observe(canvas.current);
    return () => watch.disconnect();
  }, []);
  const hover = (event) => {
    const box = canvas.current.getBoundingClientRect();
    const i = Math.floor(((event.clientX - box.left - room.left) / (box.width - room.left - room.right)) * nx);
    const j = ny - 1 - Math.floor(((event.clientY - box.top - room.top) / (height - room.top - room.bottom)) * ny);
    if (i < 0 || j < 0 || i >= nx || j >= ny) return show("");
    show(`${x.field.label} ${text(x.field, x.values[i])}, ${y.field.label} ${text(y.field, y.values[j])}: ${digits(units.shown(quantity, values[i * ny + j]))} ${units.text(quantity)}${note(i, j)}`);
  };
  return html`<figure class="panel-cell map" data-panel="map"><figcaption><h3>${units.label(quantity.label, quantity)}</h3>
      <div class="ramp"><span>${digits(low, 4)}</span><span class="ramp-bar" aria-hidden="true"></span><span>${digits(high, 4)}</span><output class="quiet">${shown}</output></div></figcaption>
    <canvas ref=${canvas} class="map-canvas" role="img" aria-label=${`${quantity.label}: ${digits(low, 4)} – ${digits(high, 4)} ${units.text(quantity)}`} onMouseMove=${hover} onMouseLeave=${() => show("")}></canvas>
    <details><summary>${T.panels.table}</summary><div class="table-scroll" tabindex="0"><table><caption>${quantity.label}</caption>
      <thead><tr><th scope="col">${x.field.label} \\ ${y.field.label}</th>${y.values.map((value) => html`<th scope="col">${text(y.field, value)}</th>`)}</tr></thead>
      <tbody>${x.values.map((value, i) => html`<tr><th scope="row">${text(x.field, value)}</th>${y.values.map((_, j) => html`<td>${digits(units.shown(quantity, values[i * ny + j]))}</td>`)}</tr>`)}</tbody></table></div></details></figure>`;
}
