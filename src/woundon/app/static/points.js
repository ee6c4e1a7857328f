// Values over the radius, drawn by dragging their points.
import { html, useLayoutEffect, useRef, useState } from "./html.js";
import { fewer } from "./schedules.js";
import { T } from "./texts.js";
import { digits, LENGTH, niceTicks } from "./units.js";

const MOST_POINTS = 40; // that can be distinguished to be dragged
const WIDE = { width: 860, height: 206, left: 58, right: 16, top: 28, bottom: 40 };
const NARROW = { ...WIDE, width: 400, height: 236 }; // of a phone, where its texts would be too small

/** Points (radius, value) that are dragged, or moved with the arrow keys. */
export function Points({ store, quantity, points, ends, put, name, own = true, usual = 0, least = 0, rest = () => {} }) {
  const { units } = store;
  const BOX = matchMedia("(max-width: 820px)").matches ? NARROW : WIDE;
  const svg = useRef(null);
  const drag = useRef(null);
  const [grip, setGrip] = useState(null);
  const top = grip ?? 1.25 * Math.max(...points.map(([, v]) => v), usual);
  const x = (r) => BOX.left + ((r - ends[0]) / (ends[1] - ends[0])) * (BOX.width - BOX.left - BOX.right);
  const y = (v) => BOX.top + (1 - v / top) * (BOX.height - BOX.top - BOX.bottom);
  const moved = (k, r, v, moving) => {
    const next = points.map((point) => [...point]);
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
  const up = () => { if (drag.current != null) { drag.current = null; rest(); setGrip(null); } };
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
  const ticks = niceTicks(0, units.shown(quantity, top));
  const radii = niceTicks(...ends.map((end) => units.shown(LENGTH, end)));
  useLayoutEffect(() => { if (drag.current != null && drag.current >= points.length) drag.current = null; });
  const fixed = points.length > MOST_POINTS;
  return html`<p class="quiet">${fixed ? T.winding.many(points.length) : T.winding.drag}</p>
    <svg ref=${svg} class="schedule-plot" viewBox=${`0 0 ${BOX.width} ${BOX.height}`} role="group" aria-label=${name}
        onPointerMove=${move} onPointerUp=${up} onPointerCancel=${up}>
      ${ticks.map((tick) => html`<g key=${tick}><path d=${`M${BOX.left} ${y(units.si(quantity, tick))}H${BOX.width - BOX.right}`} class="grid-line" /><text x=${BOX.left - 12} y=${y(units.si(quantity, tick)) + 4} class="end">${digits(tick, 4)}</text></g>`)}
      ${radii.map((tick) => html`<text key=${tick} x=${x(units.si(LENGTH, tick))} y=${BOX.height - BOX.bottom + 16}>${digits(tick, 4)}</text>`)}
      <text x=${(BOX.left + BOX.width - BOX.right) / 2} y=${BOX.height - 6} class="name">${units.label(T.winding.radius, LENGTH)}</text>
      <text x="4" y="13" class="name start">${units.label(quantity.label, quantity)}</text>
      <path d=${`M${points.map(([r, v]) => `${x(r)} ${y(v)}`).join("L")}`} class=${`schedule-line${own ? "" : " other"}`} />
      ${!fixed && points.map(([r, v], k) => html`<circle key=${k} cx=${x(r)} cy=${y(v)} r="7" class="knob" tabindex="0" role="slider" aria-valuenow=${Number(units.shown(quantity, v).toPrecision(4))}
        aria-valuemin="0" aria-valuemax=${Number(units.shown(quantity, top).toPrecision(4))} aria-valuetext=${T.winding.point(k + 1, `${digits(units.shown(LENGTH, r), 4)} ${units.text(LENGTH)}`, `${digits(units.shown(quantity, v), 4)} ${units.text(quantity)}`)}
        aria-label=${`${quantity.label} ${k + 1}`} onPointerDown=${down(k)} onKeyDown=${keys(k)} />`)}
    </svg>
    ${fixed ? html`<button type="button" onClick=${() => put(fewer(points, ends))}>${T.winding.fewer}</button>`
    : html`<button type="button" onClick=${add} disabled=${points.length >= MOST_POINTS}>${T.winding.add}</button>`}`;
}
