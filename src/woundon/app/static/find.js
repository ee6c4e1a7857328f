// The inverse problem: the value of a field for which an output reaches a target.
import * as api from "./api.js";
import { changed } from "./cases.js";
import { newCurve, newPanel } from "./chart.js";
import { html, useEffect, useRef, useState } from "./html.js";
import { QuantityBox } from "./quantity.js";
import { OnePanel } from "./results.js";
import { T } from "./texts.js";
import { digits } from "./units.js";
import { defaultVariable, labelOf, outputsOf, variables } from "./variables.js";

const WIDE = 20; // ratio of the ends of a range from which its axis is logarithmic

export function Find({ store }) {
  const { units, state } = store;
  const fields = variables(store);
  const outputs = outputsOf(store);
  const [chosen, choose] = useState({ field: "", output: "" });
  const [target, setTarget] = useState({}); // its value [SI], or the fault of its text
  const [answer, setAnswer] = useState({});
  const abort = useRef(null);
  useEffect(() => () => abort.current?.abort(), []);
  const field = fields.find((one) => one.path === chosen.field) ?? defaultVariable(store, fields);
  const output = outputs.find((one) => one.name === chosen.output) ?? outputs[0];
  if (!field || !output) return null;
  const { value, fault, shownIn } = target.unit === output.unit ? target : {};
  const rest = JSON.stringify(changed(state.case, field.path, null)); // the answer is that of this case
  const change = (patch) => { abort.current?.abort(); choose({ ...chosen, ...patch }); setAnswer({}); };
  const put = (si, wrong) => {
    change({});
    setTarget({ value: si, unit: output.unit, fault: wrong, shownIn: units });
    return si;
  };
  const run = async (event) => {
    event.preventDefault();
    abort.current?.abort();
    abort.current = new AbortController();
    const { signal } = abort.current;
    setAnswer({ busy: true });
    try {
      const found = await api.find({ case: state.case, field: field.path, output: output.name, target: value }, signal);
      setAnswer({ found, of: rest });
    } catch (error) {
      if (error.name === "AbortError") return setAnswer({});
      if (!error.superseded) setAnswer({ fault: error });
    }
  };
  return html`<form class="tab-card find" onSubmit=${run} aria-label=${T.find.title}>
    <div class="axis-row">
      <label class="stacked">${T.find.field}<select id="find-field" value=${field.path} onChange=${(event) => change({ field: event.target.value })}>
        ${fields.map((one) => html`<option value=${one.path} selected=${one === field}>${labelOf(one)}</option>`)}</select></label>
      <label class="stacked">${T.find.output}<select id="find-output" value=${output.name} onChange=${(event) => change({ output: event.target.value })}>
        ${outputs.map((one) => html`<option value=${one.name} selected=${one === output}>${one.label}</option>`)}</select></label>
      <label class="stacked small">${T.find.target} ${units.text(output) && `[${units.text(output)}]`}
        <${QuantityBox} ...${{ store, quantity: output, value, put, optional: true }} id="find-target" /></label>
      <div class="study-run"><button type="submit" class="primary" id="find-run" disabled=${!Number.isFinite(value) || answer.busy}>${T.find.run}</button>
        ${answer.busy && html`<button type="button" onClick=${() => abort.current.abort()}>${T.study.cancel}</button>`}</div>
    </div>
    <div role="status">${answer.busy && html`<p class="quiet">${T.find.busy} …</p>`}</div>
    ${(answer.fault || (fault && shownIn === units)) && html`<p class="fault" role="alert">${answer.fault ? store.textOf(answer.fault) : fault}</p>`}
    ${answer.found && answer.of === rest && html`<${Found} store=${store} found=${answer.found} />`}
  </form>`;
}

/** The solutions, and the output against the field at the points of the search. */
function Found({ store, found }) {
  const { units } = store;
  const field = store.fieldAt(found.field);
  const output = store.output(found.output);
  if (!field) return null;
  const text = (quantity, value, count) => `${digits(units.shown(quantity, value), count)} ${units.text(quantity)}`.trim();
  const error = ({ uncertainty }) => (uncertainty == null ? "" : ` ± ${digits(units.shown(field, uncertainty), 2)}`);
  const name = output.label.split(",")[0];
  const limits = [Math.min(...found.values), Math.max(...found.values)];
  const panel = newPanel({
    name: "find", x: { label: field.label, quantity: field, limits, log: limits[0] > 0 && limits[1] / limits[0] > WIDE }, y: { label: name, quantity: output },
    marks: [{ along: "x", value: found.target, label: T.find.mark }, ...found.solutions.map(({ value }) => ({ along: "y", value, label: "" }))],
    curves: [newCurve({ name: output.name, symbol: output.symbol, x: found.values, y: found.outputs })],
  });
  return html`<ul class="solutions">${found.solutions.map((solution) => html`<li key=${solution.value}>
      <b>${field.label} = ${text(field, solution.value, 5)}</b>${error(solution)}: ${name} ${text(output, solution.reached, 5)}
      <button type="button" onClick=${() => store.change(found.field, Number(solution.value.toPrecision(6)))}>${T.find.take}</button></li>`)}</ul>
    ${found.solutions.length > 1 && html`<p class="quiet">${T.find.several(found.solutions.length)}</p>`}
    ${found.unconfirmed.map(({ value, why }) => html`<p key=${value} class="quiet">${T.find.unconfirmed(text(field, value, 5), units.sentence(why))}</p>`)}
    ${found.failures.length > 0 && html`<p class="quiet">${T.find.failed(found.failures.length)}</p>`}
    <${OnePanel} store=${store} name="find" title=${T.panels.curve(name, field.label)} height=${190} cases=${[{ label: "", colour: null, panel }]} />`;
}
