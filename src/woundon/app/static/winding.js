// The winding tab: a schedule drawn by dragging its points, what the roll keeps of it, margins.
import { at } from "./cases.js";
import { html, useLayoutEffect, useRef, useState } from "./html.js";
import { Bracket, Differences, Numbers, OnePanel, Pins, Sections, states, Verdict } from "./results.js";
import { endsOf, pointsOf, profile, schedulesOf } from "./schedules.js";
import { T } from "./texts.js";
import { digits } from "./units.js";

const BOX = { width: 860, height: 190, left: 58, right: 16, top: 12, bottom: 40 };

export function Winding({ store }) {
  const { state } = store;
  const schedules = schedulesOf(store);
  const [chosen, choose] = useState("");
  const field = schedules.find((one) => one.name === chosen) ?? schedules[0];
  const good = state.result && state.result.kind === state.kind;
  return html`${good && html`<${Verdict} store=${store} /><${Numbers} store=${store} />`}
    ${!good && html`<p class="quiet">${state.problem || T.results.busy}</p>`}
    ${field && html`<section class="tab-card schedule"><div class="axis-row"><h2>${T.winding.schedule}</h2>
        ${schedules.length > 1 && html`<label class="inline"><span class="hidden">${T.winding.schedule}</span><select value=${field.name} onChange=${(event) => choose(event.target.value)}>
          ${schedules.map((one) => html`<option value=${one.name} selected=${one.name === field.name}>${one.label}</option>`)}</select></label>`}</div>
      <${Schedule} key=${field.name} store=${store} field=${field} /></section>`}
    ${good && html`<div class="bar-row"><${Pins} store=${store} />
        <button type="button" class="tables" aria-pressed=${state.tables} onClick=${() => store.set({ tables: !state.tables })}>${state.tables ? T.header.hideTables : T.header.tables}</button></div>
      <${Margins} store=${store} />
      <div class="panels">${state.result.panels.map((panel) => html`<div class="panel-cell" key=${panel.name}><${OnePanel} store=${store} name=${panel.name} height=${230}
        cases=${states(store, (one) => one.result.panels.find((other) => other.name === panel.name))} /></div>`)}</div>
      <${Bracket} store=${store} /><${Differences} store=${store} /><${Sections} store=${store} />`}`;
}

const LENGTH = { unit: "m", shown_unit: "mm" };
const MARKS = { good: "✓", bad: "✗", open: "–" };
const word = ({ ok }) => (ok == null ? "open" : ok ? "good" : "bad");

function Margins({ store }) {
  const { margins } = store.state.result;
  if (!margins?.length) return null;
  const { units } = store;
  return html`<section class="tab-card"><h2>${T.winding.margins}</h2><div class="table-scroll" tabindex="0"><table class="margins"><thead><tr>
      <th scope="col"></th><th scope="col">${T.results.value}</th><th scope="col">${T.winding.limit}</th><th scope="col">${units.label(T.winding.radius, LENGTH)}</th><th scope="col"></th></tr></thead>
    <tbody>${margins.map((margin) => {
      const { quantity } = margin;
      const text = (value) => (value == null ? "–" : `${digits(units.shown(quantity, value))} ${units.text(quantity)}`);
      return html`<tr key=${margin.name} class=${word(margin)} title=${margin.note}><th scope="row">${margin.name}<span class="quiet"> ${quantity.label}</span></th><td>${text(margin.value)}</td><td>${text(margin.limit)}</td>
        <td>${margin.radius == null ? "–" : digits(units.shown(LENGTH, margin.radius), 4)}</td><td><span class="mark" aria-hidden="true">${MARKS[word(margin)]}</span> ${T.winding[word(margin)]}</td></tr>`;
    })}</tbody></table></div></section>`;
}

function Schedule({ store, field }) {
  const { units, state } = store;
  const tables = state.case;
  const value = at(tables, field.name);
  const ends = endsOf(tables);
  const points = pointsOf(value, ends);
  const own = Array.isArray(value?.radius);
  const svg = useRef(null);
  const drag = useRef(null);
  const [grip, setGrip] = useState(null);
  const length = LENGTH;
  const top = grip ?? 1.25 * Math.max(...points.map(([, v]) => v), field.typical?.[0] ?? 0);
  const x = (r) => BOX.left + ((r - ends[0]) / (ends[1] - ends[0])) * (BOX.width - BOX.left - BOX.right);
  const y = (v) => BOX.top + (1 - v / top) * (BOX.height - BOX.top - BOX.bottom);
  const put = (next, moving) => store.change(field.name, profile(next), { moving });
  const moved = (k, r, v, moving) => {
    const next = points.map((point) => [...point]);
    const least = (field.limits?.ge ?? 0);
    const gap = (ends[1] - ends[0]) / 400;
    const inner = k > 0 && k < points.length - 1;
    next[k] = [inner ? Math.min(points[k + 1][0] - gap, Math.max(points[k - 1][0] + gap, r)) : points[k][0], Math.max(v, least, top / 200)];
    put(next, moving);
  };
  const place = (event) => {
    const box = svg.current.getBoundingClientRect();
    const px = ((event.clientX - box.left) / box.width) * BOX.width;
    const py = ((event.clientY - box.top) / box.height) * BOX.height;
    return [ends[0] + ((px - BOX.left) / (BOX.width - BOX.left - BOX.right)) * (ends[1] - ends[0]), top * (1 - (py - BOX.top) / (BOX.height - BOX.top - BOX.bottom))];
  };
  const down = (k) => (event) => { drag.current = k; setGrip(top); svg.current.setPointerCapture(event.pointerId); event.preventDefault(); event.currentTarget.focus(); };
  const move = (event) => { if (drag.current != null) moved(drag.current, ...place(event), true); };
  const up = () => { if (drag.current != null) { drag.current = null; store.moving = false; setGrip(null); } };
  const keys = (k) => (event) => {
    const [r, v] = points[k];
    const [dr, dv] = [(ends[1] - ends[0]) / 50, top / (event.shiftKey ? 20 : 100)];
    const act = { ArrowUp: [r, v + dv], ArrowDown: [r, v - dv], ArrowLeft: [r - dr, v], ArrowRight: [r + dr, v] }[event.key];
    if (act) { moved(k, ...act, true); event.preventDefault(); }
    if ((event.key === "Delete" || event.key === "Backspace") && k > 0 && k < points.length - 1) { put(points.filter((_, n) => n !== k)); event.preventDefault(); }
  };
  const add = () => {
    const widest = points.slice(1).map(([r], k) => r - points[k][0]);
    const k = widest.indexOf(Math.max(...widest));
    const middle = [0, 1].map((i) => (points[k][i] + points[k + 1][i]) / 2);
    put([...points.slice(0, k + 1), middle, ...points.slice(k + 1)]);
  };
  const ticks = nice(units.shown(field, top));
  const radii = nice(units.shown(length, ends[1])).filter((tick) => tick >= units.shown(length, ends[0]));
  useLayoutEffect(() => { if (drag.current != null && drag.current >= points.length) drag.current = null; });
  return html`<p class="quiet">${T.winding.drag}</p>
    <svg ref=${svg} class="schedule-plot" viewBox=${`0 0 ${BOX.width} ${BOX.height}`} role="group" aria-label=${`${T.winding.schedule}: ${field.label}`}
        onPointerMove=${move} onPointerUp=${up} onPointerCancel=${up}>
      ${ticks.map((tick) => html`<g key=${tick}><path d=${`M${BOX.left} ${y(units.si(field, tick))}H${BOX.width - BOX.right}`} class="grid-line" /><text x=${BOX.left - 6} y=${y(units.si(field, tick)) + 4} class="end">${digits(tick, 4)}</text></g>`)}
      ${radii.map((tick) => html`<text key=${tick} x=${x(units.si(length, tick))} y=${BOX.height - BOX.bottom + 16}>${digits(tick, 4)}</text>`)}
      <text x=${(BOX.left + BOX.width - BOX.right) / 2} y=${BOX.height - 6} class="name">${units.label(T.winding.radius, length)}</text>
      <text transform=${`translate(14 ${(BOX.height - BOX.bottom + BOX.top) / 2}) rotate(-90)`} class="name">[${units.text(field)}]</text>
      <path d=${`M${points.map(([r, v]) => `${x(r)} ${y(v)}`).join("L")}`} class=${`schedule-line${own ? "" : " other"}`} />
      ${points.map(([r, v], k) => html`<circle key=${k} cx=${x(r)} cy=${y(v)} r="7" class="knob" tabindex="0" role="slider" aria-valuenow=${Number(units.shown(field, v).toPrecision(4))}
        aria-valuemin="0" aria-valuemax=${Number(units.shown(field, top).toPrecision(4))} aria-valuetext=${T.winding.point(k + 1, `${digits(units.shown(length, r), 4)} ${units.text(length)}`, `${digits(units.shown(field, v), 4)} ${units.text(field)}`)}
        aria-label=${`${field.label} ${k + 1}`} onPointerDown=${down(k)} onKeyDown=${keys(k)} />`)}
    </svg>
    <button type="button" onClick=${add} disabled=${points.length >= 40}>${T.winding.add}</button>`;
}

/** Round numbers from 0 to an end. */
function nice(end) {
  const raw = end / 5;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((n) => n * power).find((one) => one >= raw);
  return Array.from({ length: Math.floor(end / step) + 1 }, (_, k) => k * step);
}
