// The inverse problem of a wound roll: a target pressure, drawn by dragging its points, and its tension.
import * as api from "./api.js";
import { newCurve, newPanel } from "./chart.js";
import { html, useEffect, useRef, useState } from "./html.js";
import { Points } from "./points.js";
import { OnePanel } from "./results.js";
import { endsOf, fewer, pointsOf } from "./schedules.js";
import { T } from "./texts.js";
import { digits, LENGTH } from "./units.js";

export const DESIGNED = "roll"; // the kind whose tension can be found
const TENSION = "wound_on_tension";

/** Points of the roll's pressure to start from; both ends have the mean, since the surface has none. */
function startOf(result, ends) {
  const { curves: [{ x, y }] } = result.panels.find((panel) => panel.name === "pressure");
  const points = fewer(x.map((r, k) => [r, y[k]]), ends);
  const inner = points.slice(1, -1).map(([, P]) => P);
  const level = inner.reduce((sum, P) => sum + P, 0) / inner.length;
  return points.map(([r, P], k) => [(r - ends[0]) / (ends[1] - ends[0]), Number((k === 0 || k === points.length - 1 ? level : P).toPrecision(3))]);
}

export function Design({ store }) {
  const { state } = store;
  const [open, setOpen] = useState(false);
  const [target, setTarget] = useState(null); // (share of the way from core to surface, pressure)
  const [found, setFound] = useState({});
  const newest = useRef(new api.Newest());
  const ends = endsOf(state.solved);
  const points = (target ?? []).map(([share, P]) => [ends[0] + share * (ends[1] - ends[0]), P]);
  const { [TENSION]: own, ...roll } = state.solved;
  const asked = JSON.stringify([roll, points]);
  useEffect(() => {
    if (!open) return;
    const tables = state.solved;
    const pressure = { radius: points.map(([r]) => r), value: points.map(([, P]) => P) };
    newest.current.ask(async (signal) => {
      try {
        setFound({ answer: await api.design(tables, pressure, signal), asked });
      } catch (fault) {
        if (fault.name !== "AbortError" && !fault.superseded) setFound((old) => ({ ...old, fault }));
      }
    });
  }, [open, asked]);
  useEffect(() => () => newest.current.drop(), []);
  const toggle = (event) => { setTarget(target ?? startOf(state.result, ends)); setOpen(event.target.open); };
  const put = (next) => setTarget(next.map(([r, P]) => [(r - ends[0]) / (ends[1] - ends[0]), Number(P.toPrecision(4))]));
  const take = () => {
    if (!store.full) store.pin();
    store.change(TENSION, found.answer.tension);
  };
  return html`<details class="tab-card design" open=${open} onToggle=${toggle}>
    <summary><h2>${T.design.title}</h2></summary>
    ${open && html`<p>${T.design.about}</p>
      <${Points} ...${{ store, quantity: store.output("pressure"), points, ends, put, name: T.design.target }} />
      ${found.fault && html`<p class="fault" role="alert">${store.textOf(found.fault)}</p>`}
      ${found.answer && html`<${Found} store=${store} found=${found} own=${own} />
        <button type="button" class="primary" disabled=${!!found.fault || found.asked !== asked} onClick=${take}>${T.design.take}</button>
        <span class="quiet"> ${store.full ? T.design.full : T.design.pins}</span>`}`}
  </details>`;
}

/** The tension found and that of the case; the pressures of the case, the target and the result. */
function Found({ store, found: { answer, fault }, own }) {
  const { units, state } = store;
  const pressure = store.output("pressure");
  const now = pointsOf(own, endsOf(state.solved));
  const before = state.result.panels.find((panel) => panel.name === "pressure").curves[0];
  const along = { label: T.winding.radius, quantity: LENGTH };
  const curve = (symbol, label, colour, line, x, y) => newCurve({ name: label, symbol, label, colour, line, x, y });
  const panel = (name, words, quantity, curves) => [{ label: "", colour: null, panel: newPanel({
    name, column: "design", x: along, y: { label: words, quantity, from_zero: true }, curves,
  }) }];
  const tension = store.fieldAt(TENSION);
  const shown = [
    [T.design.tension, panel("design_tension", T.design.tension, tension, [
      curve(tension.symbol, T.design.found, "roll", "solid", answer.tension.radius, answer.tension.value),
      curve(tension.symbol, T.design.now, "web", "dashdot", now.map(([r]) => r), now.map(([, v]) => v))])],
    [T.design.pressure, panel("design_pressure", T.design.pressure, pressure, [
      curve(pressure.symbol, T.design.reached, "roll", "solid", answer.radius, answer.pressure),
      curve(pressure.symbol, T.design.target, "drum", "dashed", answer.radius, answer.target_pressure),
      curve(pressure.symbol, T.design.now, "web", "dashdot", before.x, before.y)])],
  ];
  const size = (quantity, value) => `${digits(units.shown(quantity, value), 3)} ${units.text(quantity)}`;
  return html`<div class=${fault ? "stale" : ""}><p class="quiet">${answer.outer_layer > 0
    ? T.design.layer(size(LENGTH, answer.outer_layer), size(pressure, answer.surface_deviation)) : T.design.met}</p>
    <div class="panels">${shown.map(([title, cases]) => html`<div class="panel-cell" key=${title}><${OnePanel} store=${store} name=${cases[0].panel.name} title=${title} cases=${cases} /></div>`)}</div></div>`;
}
