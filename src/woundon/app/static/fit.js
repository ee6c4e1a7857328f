// Fit of one or two fields to a table of measured values, with progress and cancel.
import * as api from "./api.js";
import { at, changed } from "./cases.js";
import { newCurve, newPanel } from "./chart.js";
import { html, useState } from "./html.js";
import { RunButtons, runStudy, StudyState } from "./progress.js";
import { OnePanel } from "./results.js";
import { End } from "./study.js";
import { T } from "./texts.js";
import { digits } from "./units.js";
import { labelOf, outputsOf, variables } from "./variables.js";

const FACTOR = 4; // bounds from the value over this to the value times this
const PREFERRED = ["roll_friction", "friction"]; // what is usually unknown

/** Bounds around the value of a field, within its permitted range. */
function boundsOf({ field: { limits = {} }, value }) {
  const [low, high] = [limits.gt ?? limits.ge ?? -Infinity, limits.lt ?? limits.le ?? Infinity];
  const ends = value > 0 ? [value / FACTOR, value * FACTOR] : [low, high];
  return [Math.max(ends[0], low), Math.min(ends[1], high)].map((end) => Number(end.toPrecision(3)));
}

/** A table to start from: the load, and the main output of the present case, in the shown units. */
function exampleTable(store) {
  const { units, state, kind } = store;
  const load = store.loadOf(kind);
  const [output] = outputsOf(store);
  const names = [...(load ? [units.label(load, store.fieldAt(load))] : []), units.label(output.name, output)];
  const rows = (load ? [0.75, 1, 1.25] : [1]).map((factor) => [
    ...(load ? [digits(units.shown(store.fieldAt(load), factor * at(state.case, load)), 4)] : []),
    factor === 1 ? digits(units.shown(output, state.result.outputs[output.name].value), 4) : "",
  ].join("\t"));
  return [names.join("\t"), ...rows].join("\n");
}

const base64 = async (file) => btoa(Array.from(new Uint8Array(await file.arrayBuffer()), (byte) => String.fromCharCode(byte)).join(""));

export function Fit({ store }) {
  const { state, catalogue } = store;
  const { limits } = catalogue;
  const [table, setTable] = useState({ text: "", name: "" }); // a file has a name, a text that is typed has none
  const [sheet, setSheet] = useState(""); // of an Excel or instrument file
  const [picked, pick] = useState([]);
  const [ends, setEnds] = useState({});
  const fields = variables(store);
  const usual = PREFERRED.map((path) => fields.find((one) => one.path === path)).find(Boolean) ?? fields[0];
  const first = fields.find((one) => one.path === picked[0]) ?? usual;
  const second = fields.find((one) => one.path === picked[1] && one !== first);
  const unknown = [first, second].filter(Boolean);
  const endsOf = (one) => ends[one.path] ?? boundsOf(one);
  const fit = state.fit?.kind === state.kind ? state.fit : null;
  const ready = table.text.trim() && unknown.every((one) => { const [low, high] = endsOf(one); return low < high; });
  const load = async (file) => {
    if (!file) return;
    const binary = /\.(xls[xm]|tdms)$/i.test(file.name);
    // base64 has four characters for three bytes
    if (file.size * (binary ? 4 / 3 : 1) > 0.9 * limits.body_bytes) return setTable({ text: "", name: "", fault: T.fit.tooBig(digits(file.size / 1e6, 3)) });
    if (binary || /\.lvm$/i.test(file.name)) setTable({ text: await (binary ? base64(file) : file.text()), name: file.name });
    else setTable({ text: await file.text(), name: "" });
  };
  const run = () => {
    const body = { case: state.case, table: table.text, ...(table.name && { file: sheet.trim() ? `${table.name}#${sheet.trim()}` : table.name }), vary: Object.fromEntries(unknown.map((one) => [one.path, endsOf(one)])) };
    const take = (event, { of }) => (event.event === "fitted" ? { found: event, done: of } : {});
    return runStudy(store, "fit", (handle, signal) => api.fit(body, handle, signal), take);
  };
  const unknownRow = (k, one) => html`<div class="axis-row" key=${k}>
    <label class="stacked">${T.fit.unknown(k + 1)}<select id=${`fit-field-${k}`} value=${one?.path ?? ""} onChange=${(event) => pick(k ? [first.path, event.target.value] : [event.target.value, second?.path])}>
      ${k > 0 && html`<option value="" selected=${!one}>${T.study.none}</option>`}
      ${fields.filter((other) => !k || other !== first).map((other) => html`<option value=${other.path} selected=${other === one}>${labelOf(other)}</option>`)}</select></label>
    ${[T.fit.low, T.fit.high].map((words, n) => html`<${End} key=${n} ...${{ store, id: `fit-${k}-${n}`, words, field: one?.field, value: one && endsOf(one)[n],
      put: (value) => setEnds({ ...ends, [one.path]: endsOf(one).map((end, m) => (m === n ? value : end)) }) }} />`)}</div>`;
  return html`<section class="tab-card fit"><h2>${T.fit.title}</h2><p class="quiet">${T.fit.about}</p>
    <label class="stacked">${T.fit.table(limits.fit_rows)}<textarea id="fit-table" rows="6" spellcheck="false" placeholder=${T.fit.example}
      value=${table.name ? "" : table.text} disabled=${!!table.name} onInput=${(event) => setTable({ text: event.target.value, name: "" })}></textarea></label>
    <div class="bar-row"><label class="file">${T.fit.file} <input type="file" id="fit-file" accept=".csv,.txt,.tsv,.xlsx,.xlsm,.lvm,.tdms" onChange=${(event) => load(event.target.files[0])} /></label>
      ${table.name ? html`<span>${table.name} <label>${T.fit.sheet} <input id="fit-sheet" size="12" value=${sheet} onInput=${(event) => setSheet(event.target.value)} /></label> <button type="button" onClick=${() => setTable({ text: "", name: "" })}>${T.fit.drop}</button></span>`
    : state.result?.kind === state.kind && html`<button type="button" id="fit-example" onClick=${() => setTable({ text: exampleTable(store), name: "" })}>${T.fit.columns}</button>`}</div>
    ${table.fault && html`<p class="fault" role="alert">${table.fault}</p>`}
    <div class="study-form">${[first, second].map((one, k) => unknownRow(k, one))}
      <${RunButtons} ...${{ name: "fit", study: fit, words: T.fit.run, ready, run }} /></div>
    <${StudyState} ...${{ store, study: fit, words: fit && T.fit.progress(fit.done, fit.of) }} />
  </section>
  ${fit?.found && html`<${Found} store=${store} found=${fit.found} />`}`;
}

function Found({ store, found: { parameters, rows, remarks, rms, is_weighted: weighted } }) {
  const { units, state } = store;
  const outputs = [...new Set(rows.map((row) => row.output))];
  const text = (quantity, value, count = 4) => (value == null ? T.fit.open : digits(units.shown(quantity, value), count));
  const take = () => store.take(state.kind, parameters.reduce((tables, { name, estimate }) => changed(tables, name, Number(estimate.toPrecision(5))), state.case));
  const first = store.output(outputs[0]);
  return html`<section class="tab-card" id="fit-found">
    ${parameters.map(({ name, estimate, standard_error: error, interval }) => {
    const field = store.fieldAt(name);
    return html`<p class="answer" key=${name} data-parameter=${name} data-si=${estimate}>${field.label} = ${text(field, estimate)}${error == null ? "" : ` ± ${text(field, error, 2)}`} ${units.text(field)}
      ${interval && html`<span class="quiet"> ${T.fit.interval(text(field, interval[0]), text(field, interval[1]))}</span>`}</p>`;
  })}
    <p>${T.fit.rms(weighted ? `${digits(rms, 2)} ${T.fit.deviations}` : `${text(first, rms, 2)} ${units.text(first)}`, rows.length)} <button type="button" id="fit-take" onClick=${take}>${T.fit.take}</button></p>
    <ul class="remarks">${remarks.map((line) => html`<li key=${line}>${units.sentence(line)}</li>`)}</ul>
  </section>
  <div class="panels">${outputs.map((name) => html`<${Agreement} key=${name} store=${store} output=${store.output(name)} rows=${rows.filter((row) => row.output === name)} />`)}</div>`;
}

/** Fitted against measured values, and their table. */
function Agreement({ store, output, rows }) {
  const { units } = store;
  const values = rows.flatMap(({ measured, fitted }) => [measured, fitted]);
  const ends = [Math.min(...values), Math.max(...values)];
  const margin = 0.05 * (ends[1] - ends[0] || Math.abs(ends[0]) || 1);
  const limits = [ends[0] - margin, ends[1] + margin];
  const ordered = [...rows].sort((a, b) => a.measured - b.measured);
  const panel = newPanel({
    name: "fit", column: `fit-${output.name}`, x: { label: T.fit.measured, quantity: output, limits }, y: { label: T.fit.fitted, quantity: output },
    curves: [
      newCurve({ name: "fitted", label: T.fit.rows, line: "none", x: ordered.map((row) => row.measured), y: ordered.map((row) => row.fitted) }),
      newCurve({ name: "equal", label: T.fit.equal, colour: "web", line: "dashed", x: limits, y: limits }),
    ],
  });
  return html`<div class="panel-cell"><${OnePanel} store=${store} name="fit" title=${output.label} height=${280} tables=${false} cases=${[{ label: "", colour: null, panel }]} />
    <details><summary>${T.panels.table}</summary><div class="table-scroll" tabindex="0"><table><caption>${units.label(output.label, output)}</caption>
      <thead><tr>${[T.fit.row, T.fit.measured, T.fit.fitted, T.fit.difference].map((words) => html`<th scope="col">${words}</th>`)}</tr></thead>
      <tbody>${rows.map(({ row, measured, fitted }) => html`<tr key=${row}><th scope="row">${row}</th>${[measured, fitted].map((value) => html`<td>${digits(units.shown(output, value), 4)}</td>`)}
        <td>${digits(units.shown(output, fitted - measured), 2)}</td></tr>`)}</tbody></table></div></details></div>`;
}
