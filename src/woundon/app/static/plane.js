// Panels over a plane: coloured maps with contours, cross sections of rolls, curves over a depth.
import { axisLabel, colourOf, linesOf, Swatch } from "./chart.js";
import { html, useEffect, useLayoutEffect, useRef, useState } from "./html.js";
import { Symbol, Words } from "./symbols.js";
import { T } from "./texts.js";
import { digits, niceTicks } from "./units.js";

const LEFT = 58;
const RIGHT = 74; // with the scale of the colours
const UNIT = 22; // height of the unit above the scale of the colours
const BELOW = 34;
const DASHES = { solid: [], dashed: [7, 4], dashdot: [8, 3, 2, 3], dotted: [2, 3] };
const SEQUENTIAL = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
const SHADES = 256; // of a map
const DIVERGING = [[33, 102, 172], [146, 197, 222], [247, 247, 247], [244, 165, 130], [178, 24, 43]];

/** Whether a panel is drawn here, and not as curves over x. */
export const isPlane = (panel) => !!(panel.map || panel.to_scale || panel.discs.length || panel.note || (panel.y.limits && panel.y.limits[0] > panel.y.limits[1])
  || panel.curves.some(({ x }) => x.length > 1 && x.every((value) => value === x[0]))); // an upright line is no curve over x

/** The colour of a value on a scale: red, green, blue. */
function colourAt(value, { axis: { limits: [low, high] }, palette }) {
  const stops = palette === "sequential" ? SEQUENTIAL : palette === "red above" ? DIVERGING : [...DIVERGING].reverse();
  const place = Math.min(Math.max((value - low) / (high - low), 0), 1) * (stops.length - 1);
  const k = Math.min(Math.floor(place), stops.length - 2);
  return stops[k].map((from, n) => Math.round(from + (place - k) * (stops[k + 1][n] - from)));
}

/** A linear or logarithmic map from the ends of an axis to pixels. */
function scaled({ log, limits }, from, to) {
  const of = log ? Math.log : (value) => value;
  const [first, last] = limits.map(of);
  return (value) => from + (to - from) * (of(value) - first) / (last - first);
}

/** An axis with limits: its own, or those of values. */
function limited(axis, values) {
  if (axis.limits) return axis;
  const known = values.filter(Number.isFinite);
  const [low, high] = [Math.min(...known, 0), Math.max(...known, 0)];
  return { ...axis, limits: [low - 0.05 * (high - low), high + 0.05 * (high - low)] };
}

/** The place of the middle of a text along a canvas, from one edge to the other, so that it is whole. */
const inside = (middle, size, edge) => Math.min(Math.max(middle, size / 2), Math.max(edge - size / 2, size / 2));

class Pen {
  constructor(canvas, width, height) {
    Object.assign(this, { width, height });
    canvas.width = width * devicePixelRatio;
    canvas.height = height * devicePixelRatio;
    canvas.style.height = `${height}px`;
    this.ctx = canvas.getContext("2d");
    this.ctx.scale(devicePixelRatio, devicePixelRatio);
    this.ctx.clearRect(0, 0, width, height);
  }

  text(words, x, y, { align = "center", turned = false, bold = false, colour = colourOf("soft") } = {}) {
    const { ctx } = this;
    ctx.save();
    ctx.fillStyle = colour;
    ctx.font = `${bold ? "600 " : ""}11px system-ui, sans-serif`;
    ctx.textAlign = align;
    ctx.textBaseline = "middle";
    const size = ctx.measureText(words).width;
    ctx.translate(align === "center" && !turned ? inside(x, size, this.width) : x, turned ? inside(y, size, this.height) : y);
    if (turned) ctx.rotate(-Math.PI / 2);
    ctx.fillText(words, 0, 0);
    ctx.restore();
  }

  line(points, colour, dash = [], width = 2) {
    const { ctx } = this;
    ctx.strokeStyle = colour;
    ctx.lineWidth = width;
    ctx.setLineDash(dash);
    ctx.beginPath();
    points.forEach(([x, y], k) => (k ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
    ctx.stroke();
    ctx.setLineDash([]);
  }
}

/** Ticks of an axis in the shown units. */
function ticksOf({ log, limits }, factor, count) {
  const [low, high] = [Math.min(...limits) / factor, Math.max(...limits) / factor];
  if (!log) return niceTicks(low, high, count);
  const powers = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) powers.push(power);
  return powers.flatMap((power) => [1, 2, 5].map((digit) => Number(`${digit}e${power}`))).filter((tick) => tick >= low && tick <= high);
}

function drawScale(pen, scale, units, right, height) {
  const { quantity, limits: [low, high] } = scale.axis;
  const { factor } = units.of(quantity);
  const y = (value) => height - BELOW + (UNIT - height + BELOW) * (value - low) / (high - low);
  for (let k = 0; k < 64; k++) {
    const value = low + (high - low) * k / 64;
    pen.ctx.fillStyle = `rgb(${colourAt(value, scale)})`;
    pen.ctx.fillRect(right, y(value + (high - low) / 64), 10, y(value) - y(value + (high - low) / 64) + 1);
  }
  for (const tick of niceTicks(low / factor, high / factor, 4)) pen.text(digits(tick, 4), right + 14, y(tick * factor), { align: "left" });
  pen.text(units.label("", quantity).trim(), right + 4, 7, { align: "left", bold: true });
}

function drawDiscs(pen, { discs, scale, x }, units, width, height) {
  const { factor } = units.of(x.quantity);
  const last = discs.at(-1);
  const reach = last.radius.at(-1);
  const whole = last.left + 2 * reach - discs[0].left;
  const size = Math.min((width - RIGHT - 16) / whole, (height - BELOW - 8) / (2 * reach));
  for (const { radius, values, left } of discs) {
    const centre = [8 + (left - discs[0].left + radius.at(-1)) * size, 4 + (height - BELOW) / 2];
    const circle = (r, colour) => {
      pen.ctx.fillStyle = colour;
      pen.ctx.beginPath();
      pen.ctx.arc(...centre, r * size, 0, 2 * Math.PI);
      pen.ctx.fill();
    };
    for (let k = radius.length - 1; k > 0; k--) circle(radius[k], `rgb(${colourAt(values[k], scale)})`);
    circle(radius[0], colourOf("line"));
    const text = digits(radius.at(-1) / factor, 3);
    pen.text(discs.length > 1 ? text : `R ${text} ${units.text(x.quantity)}`, centre[0], centre[1] + radius.at(-1) * size + 9);
  }
  if (discs.length > 1) pen.text(units.label(x.label, x.quantity), 8, height - 8, { align: "left", bold: true });
}

/** Segments of the contour of a map by marching squares. */
function contour({ x, y, values }, level, draw) {
  const cross = (a, b, va, vb) => a + (b - a) * (level - va) / (vb - va);
  for (let j = 0; j + 1 < y.length; j++) {
    for (let i = 0; i + 1 < x.length; i++) {
      const [a, b, c, d] = [values[j][i], values[j][i + 1], values[j + 1][i + 1], values[j + 1][i]];
      const points = [];
      if ((a < level) !== (b < level)) points.push([cross(x[i], x[i + 1], a, b), y[j]]);
      if ((b < level) !== (c < level)) points.push([x[i + 1], cross(y[j], y[j + 1], b, c)]);
      if ((c < level) !== (d < level)) points.push([cross(x[i + 1], x[i], c, d), y[j + 1]]);
      if ((d < level) !== (a < level)) points.push([x[i], cross(y[j + 1], y[j], d, a)]);
      for (let k = 0; k + 1 < points.length; k += 2) draw(points[k], points[k + 1]);
    }
  }
}

/** Draw the cells of a map: neighbours of the same shade as one, for each move of a slider draws it again. */
function drawMap(pen, { map, scale }, x, y) {
  const middles = (of, values) => values.map((value, k) => (k ? (of(values[k - 1]) + of(value)) / 2 : of(value))).concat(of(values.at(-1)));
  // whole pixels: an edge within one would let the background show through
  const [edges, rows] = [middles(x, map.x), middles(y, map.y)].map((values) => values.map(Math.round));
  const [low, high] = scale.axis.limits;
  const shades = Array.from({ length: SHADES }, (_, k) => `rgb(${colourAt(low + (high - low) * k / (SHADES - 1), scale)})`);
  const shadeOf = (value) => Math.round(Math.min(Math.max((value - low) / (high - low), 0), 1) * (SHADES - 1));
  map.values.forEach((row, j) => {
    const of = row.map(shadeOf);
    const [top, height] = [Math.min(rows[j], rows[j + 1]), Math.abs(rows[j + 1] - rows[j])];
    let first = 0; // of the cells of the same shade
    for (let i = 1; i <= row.length; i++) {
      if (of[i] === of[first]) continue;
      pen.ctx.fillStyle = shades[of[first]];
      pen.ctx.fillRect(edges[first], top, edges[i] - edges[first], height);
      first = i;
    }
  });
}

function drawAxes(pen, panel, axes, units, right, bottom) {
  for (const tick of ticksOf(axes.x, axes.x.factor, 6)) pen.text(digits(tick, 4), axes.x.at(tick * axes.x.factor), bottom + 9);
  for (const tick of ticksOf(axes.y, axes.y.factor, 6)) pen.text(digits(tick, 4), LEFT - 5, axes.y.at(tick * axes.y.factor), { align: "right" });
  pen.text(axisLabel(units, panel.x, pen.width), (LEFT + right) / 2, bottom + 25, { bold: true });
  pen.text(axisLabel(units, panel.y, pen.height), 10, (8 + bottom) / 2, { turned: true, bold: true });
  pen.line([[LEFT, 8], [LEFT, bottom], [right, bottom]], colourOf("line"), [], 1);
}

/** Let both axes have the same scale, the smaller of the two; the other axis shows more around its middle. */
function alike(axes, ends) {
  const [x, y] = [axes.x, axes.y].map(({ limits: [low, high] }) => high - low);
  const [width, height] = [ends.x[1] - ends.x[0], ends.y[0] - ends.y[1]];
  const scale = Math.min(width / x, height / y);
  for (const [name, size] of [["x", width], ["y", height]]) {
    const axis = axes[name];
    const middle = (axis.limits[0] + axis.limits[1]) / 2;
    axis.limits = [middle - size / scale / 2, middle + size / scale / 2];
    axis.at = scaled(axis, ...ends[name]);
  }
}

function drawPlane(pen, cases, units, width, height) {
  const { panel } = cases[0];
  const lines = linesOf(cases);
  const [right, bottom] = [width - (panel.scale ? RIGHT : 16), height - BELOW];
  const ends = { x: [LEFT, right], y: [bottom, 8] };
  const axes = Object.fromEntries(["x", "y"].map((name) => {
    const axis = limited(panel[name], lines.flatMap(({ curve }) => curve[name]));
    return [name, { ...axis, at: scaled(axis, ...ends[name]), factor: units.of(axis.quantity).factor }];
  }));
  if (panel.to_scale) alike(axes, ends);
  const at = ([x, y]) => [axes.x.at(x), axes.y.at(y)];
  pen.ctx.save();
  pen.ctx.beginPath();
  pen.ctx.rect(LEFT, 8, right - LEFT, bottom - 8);
  pen.ctx.clip();
  if (panel.map && cases.length === 1) drawMap(pen, panel, axes.x.at, axes.y.at);
  for (const { panel: own, colour } of cases) {
    for (const { level } of own.map?.contours ?? []) contour(own.map, level, (from, to) => pen.line([at(from), at(to)], colour ?? "#000", [], 1.4));
    for (const { value } of own.marks) pen.line([[axes.x.at(value), 8], [axes.x.at(value), bottom]], colour ?? colourOf("soft"), value ? DASHES.dotted : [], 1);
  }
  for (const { one, curve } of lines) pen.line(curve.x.map((x, k) => at([x, curve.y[k]])), one.colour ?? colourOf(curve.colour), DASHES[curve.line]);
  pen.ctx.restore();
  drawAxes(pen, panel, axes, units, right, bottom);
}

/** A panel over a plane with its legend; of several cases contours and curves are compared. */
export function Plane({ title, cases, units, height, theme, description }) {
  const place = useRef(null);
  const { panel } = cases[0];
  const drawn = useRef(0); // width of the picture
  const draw = () => {
    const width = place.current?.parentElement.clientWidth;
    drawn.current = width;
    if (!width || panel.note) return;
    const pen = new Pen(place.current, width, height + 40);
    if (panel.discs.length) drawDiscs(pen, panel, units, width, height + 40);
    else drawPlane(pen, cases, units, width, height + 40);
    if (panel.scale && (panel.discs.length || cases.length === 1)) drawScale(pen, panel.scale, units, width - RIGHT + 12, height + 40);
  };
  useLayoutEffect(() => {
    draw();
    const around = place.current.parentElement;
    const watch = new ResizeObserver(() => { if (around.clientWidth !== drawn.current) draw(); }); // it is called at once, too
    watch.observe(around);
    return () => watch.disconnect();
  }, [cases, units]);
  const painted = useRef(theme);
  useEffect(() => { // by now the page has forgotten the colours of the theme before
    if (painted.current !== theme) draw();
    painted.current = theme;
  }, [theme]);
  const several = cases.length > 1;
  return html`<figure class="panel" data-panel=${panel.name}><figcaption><h3>${title}</h3><div class="legend">
      ${linesOf(cases).filter(({ curve }) => curve.in_legend).map(({ one, curve }) => html`<span class="entry"><${Swatch} curve=${curve} colour=${one.colour} />
        ${several && html`<b>${one.label} </b>`}<span class="symbol"><${Symbol} of=${curve.symbol} /></span> <span><${Words} of=${units.sentence(curve.label)} /></span></span>`)}
      ${(panel.map?.contours ?? []).map((one) => html`<span class="entry"><${Swatch} curve=${{ line: "solid", colour: "ink" }} />${one.label}</span>`)}
      ${panel.scale && html`<span class="entry">${panel.scale.axis.label}</span>`}
    </div></figcaption>
    ${panel.note ? html`<p class="quiet">${panel.note}</p>` : ""}
    <div class="plane"><canvas ref=${place} role="img" aria-label=${description}></canvas></div></figure>`;
}

// ---- maps of an output over two fields ----

const MAP = { left: 66, right: 14, top: 10, bottom: 44, height: 420 };

/**
 * The values of an output over two fields, small ones light; the value under the pointer is shown,
 * and `note(i, j)` after it.  `values` runs along y first; null where there is none.
 */
export function ValueMap({ store, x, y, values, quantity, note = () => "", range = null }) {
  const { units } = store;
  const canvas = useRef(null);
  const [shown, show] = useState("");
  const known = values.filter((value) => value != null);
  const [low, high] = range ?? (known.length ? [Math.min(...known), Math.max(...known)] : [0, 1]);
  const [nx, ny] = [x.values.length, y.values.length];
  const text = (field, value, count = 4) => digits(units.shown(field, value), count);
  const draw = () => {
    const width = canvas.current?.clientWidth;
    if (!width) return;
    const pen = new Pen(canvas.current, width, MAP.height);
    const { ctx } = pen;
    const [w, h] = [(width - MAP.left - MAP.right) / nx, (MAP.height - MAP.top - MAP.bottom) / ny];
    const at = (i, j) => [MAP.left + i * w, MAP.top + (ny - 1 - j) * h];
    values.forEach((value, k) => {
      const [left, top] = at(Math.floor(k / ny), k % ny);
      if (value == null) {
        ctx.strokeStyle = colourOf("line");
        ctx.strokeRect(left + 1, top + 1, w - 2, h - 2);
        return;
      }
      const rgb = colourAt(value, { axis: { limits: [high, low === high ? high - 1 : low] }, palette: "sequential" });
      ctx.fillStyle = `rgb(${rgb})`;
      ctx.fillRect(left, top, w + 0.6, h + 0.6);
      const words = text(quantity, value, 3);
      const isLight = 0.3 * rgb[0] + 0.59 * rgb[1] + 0.11 * rgb[2] > 130;
      if (w > ctx.measureText(words).width + 6 && h > 14) pen.text(words, left + w / 2, top + h / 2, { colour: isLight ? "#111" : "#fff" });
    });
    const every = (size, label) => Math.max(1, Math.ceil(label / size)); // so many cells have one label
    const below = MAP.height - MAP.bottom;
    for (let i = 0; i < nx; i += every(w, 54)) pen.text(text(x.field, x.values[i]), at(i, 0)[0] + w / 2, below + 12);
    for (let j = 0; j < ny; j += every(h, 16)) pen.text(text(y.field, y.values[j]), MAP.left - 6, at(0, j)[1] + h / 2, { align: "right" });
    pen.text(axisLabel(units, { label: x.field.label, quantity: x.field }, width), MAP.left + (nx * w) / 2, MAP.height - 10, { bold: true });
    pen.text(axisLabel(units, { label: y.field.label, quantity: y.field }, MAP.height), 10, (MAP.top + below) / 2, { turned: true, bold: true });
  };
  const redraw = useRef(draw);
  redraw.current = draw;
  useEffect(draw); // by now the page has forgotten the colours of the theme before
  useEffect(() => {
    const watch = new ResizeObserver(() => redraw.current());
    watch.observe(canvas.current);
    return () => watch.disconnect();
  }, []);
  const hover = (event) => {
    const box = canvas.current.getBoundingClientRect();
    const i = Math.floor(((event.clientX - box.left - MAP.left) / (box.width - MAP.left - MAP.right)) * nx);
    const j = ny - 1 - Math.floor(((event.clientY - box.top - MAP.top) / (MAP.height - MAP.top - MAP.bottom)) * ny);
    if (i < 0 || j < 0 || i >= nx || j >= ny) return show("");
    show(`${x.field.label} ${text(x.field, x.values[i])}, ${y.field.label} ${text(y.field, y.values[j])}: ${text(quantity, values[i * ny + j], 5)} ${units.text(quantity)}${note(i, j)}`);
  };
  return html`<figure class="panel-cell map" data-panel="map"><figcaption><h3>${units.label(quantity.label, quantity)}</h3>
      <div class="ramp"><span>${text(quantity, low)}</span><span class="ramp-bar" aria-hidden="true"></span><span>${text(quantity, high)}</span><output class="quiet">${shown}</output></div></figcaption>
    <canvas ref=${canvas} class="map-canvas" role="img" aria-label=${`${quantity.label}: ${text(quantity, low)} – ${text(quantity, high)} ${units.text(quantity)}`} onMouseMove=${hover} onMouseLeave=${() => show("")}></canvas>
    <details><summary>${T.panels.table}</summary><div class="table-scroll" tabindex="0"><table><caption>${quantity.label}</caption>
      <thead><tr><th scope="col">${x.field.label} \\ ${y.field.label}</th>${y.values.map((value) => html`<th scope="col">${text(y.field, value)}</th>`)}</tr></thead>
      <tbody>${x.values.map((value, i) => html`<tr><th scope="row">${text(x.field, value)}</th>${y.values.map((_, j) => html`<td>${text(quantity, values[i * ny + j], 5)}</td>`)}</tr>`)}</tbody></table></div></details></figure>`;
}
