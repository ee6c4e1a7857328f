// A panel drawn by uPlot: curves, shaded bounds, strips of zones, marks; hover, zoom, keys.
/* global uPlot */
import { html, useEffect, useLayoutEffect, useRef } from "./html.js";
import { Symbol, Words } from "./symbols.js";
import { digits, niceTicks } from "./units.js";

const DASHES = { solid: [], dashed: [7, 4], dashdot: [8, 3, 2, 3], dotted: [2, 3] };
const DOTS = { dash: [], paths: () => null, points: { show: true, size: 8 } }; // points without a line
const LEFT = 58;
const RIGHT = 54;
const MARGIN = 40; // [px] of the height without room for a label along y: it is centred on the curves
const LABEL_FONT = "600 11px system-ui, sans-serif";

// ---- colours of the style sheet, read once a theme ----

let palette = null;
export const forgetColours = () => { palette = null; hatches.clear(); };
function colours() {
  if (!palette) {
    const style = getComputedStyle(document.documentElement);
    const names = ["ink", "soft", "line", "roll", "drum", "web", "green", "purple", "sky", "amber", "alarm", "shade0", "shade1", "shade-drum", "shade-alarm", "card", "stick", "faster",
      "slower", "hatch", "live", "pin-A", "pin-B", "pin-C", "pin-D"];
    palette = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  }
  return palette;
}
export const colourOf = (name) => colours()[name];

const hatches = new Map(); // by zone and size
function hatched(ctx, zone, size) {
  const key = `${zone} ${size}`;
  if (!hatches.has(key)) hatches.set(key, newHatch(ctx, zone, size));
  return hatches.get(key);
}

function newHatch(ctx, zone, size) {
  const tile = document.createElement("canvas");
  tile.width = tile.height = size;
  const pen = tile.getContext("2d");
  const { stick, faster, slower, hatch } = colours();
  pen.fillStyle = zone === 0 ? stick : zone > 0 ? faster : slower;
  pen.fillRect(0, 0, size, size);
  if (zone !== 0) {
    pen.strokeStyle = hatch;
    pen.lineWidth = size / 9;
    pen.beginPath();
    for (const shift of [-size, 0, size]) { // leaning with the slip
      pen.moveTo(shift - 1, zone > 0 ? size + 1 : -1);
      pen.lineTo(shift + size + 1, zone > 0 ? -1 : size + 1);
    }
    pen.stroke();
  }
  return ctx.createPattern(tile, "repeat");
}

/** A panel that the page makes itself, as the server describes panels. */
export const newPanel = (parts) => ({
  right: null, areas: [], marks: [], strips: [], words: [], discs: [], map: null, to_scale: false, scale: null, note: "", column: parts.name, ...parts,
});

/** A curve of such a panel. */
export const newCurve = (parts) => ({
  symbol: "", label: "", colour: "roll", line: "solid", right: false, alone: false, in_legend: true, opacity: 1, ...parts,
});

/** The curves of all cases that are drawn: of several cases those that compare them. */
export const linesOf = (cases) => cases.flatMap((one) => one.panel.curves.filter((curve) => cases.length === 1 || !curve.alone).map((curve) => ({ one, curve })));

/** Curves as tables, one for each set of x: {x, axis, columns: [{one, curve, axis}]}. */
export function tablesOf(lines) {
  const tables = new Map();
  for (const { one, curve } of lines) {
    const { panel } = one;
    const key = JSON.stringify(curve.x);
    if (!tables.has(key)) tables.set(key, { x: curve.x, axis: panel.x, columns: [] });
    tables.get(key).columns.push({ one, curve, axis: curve.right ? panel.right : panel.y });
  }
  return [...tables.values()];
}

/** Whether points are drawn without a line. */
const isDots = (curve) => curve.line === "none";

const pen = document.createElement("canvas").getContext("2d");

/** The label of an axis; one that is longer than its room has no words after a comma, or the unit alone: titles have them. */
export function axisLabel(units, { label, quantity }, room) {
  pen.font = LABEL_FONT;
  const shorter = [label, label.split(",")[0], ""].map((words) => units.label(words, quantity).trim());
  return shorter.find((words) => pen.measureText(words).width <= room) ?? "";
}

// ---- what runs along x is shared by the panels of a column ----

const columns = new Map(); // zoom: [SI], as the units that are shown may change
function columnOf(name) {
  if (!columns.has(name)) columns.set(name, { zoom: null, charts: new Set() });
  return columns.get(name);
}

function zoomTo(name, zoom) {
  const column = columnOf(name);
  column.zoom = zoom;
  for (const chart of column.charts) chart.fit();
}

// ---- one chart ----

/** uPlot on a panel of one or more cases; each case is {label, colour, panel}, the live one first. */
class Chart {
  constructor(place, onReading) {
    this.place = place;
    this.onReading = onReading;
    this.plot = null;
    this.key = "";
    this.inSight = true;
    this.late = null; // what is to be shown when it comes into sight again
  }

  show(cases, units, height) {
    this.late = this.plot && !this.inSight ? [cases, units, height] : null;
    if (this.late) return;
    this.cases = cases;
    this.units = units;
    const { panel } = cases[0];
    this.column = panel.column || panel.name;
    this.lines = linesOf(cases);
    const key = JSON.stringify([
      units.name, height, colours().ink, panel.name, panel.x.log, panel.x.label, panel.y.label, !!panel.right, panel.strips.length > 0 && cases.map((one) => one.label),
      this.lines.map(({ one, curve }) => [one.colour, curve.colour, curve.line, curve.right]),
    ]);
    const data = this.data();
    if (!this.plot || key !== this.key) this.make(key, data, height);
    else this.plot.batch(() => { this.plot.setData(data, false); this.fit(); });
  }

  look(inSight) {
    this.inSight = inSight;
    if (inSight && this.late) this.show(...this.late);
  }

  /** The strips of all cases below each other. */
  rows() {
    return this.cases.flatMap((one) => one.panel.strips.map((strip) => ({ one, strip })));
  }

  data() {
    const { units } = this;
    const { panel } = this.cases[0];
    if (panel.strips.length) {
      const [low, high] = this.range();
      return [[low, high], [0, 0]];
    }
    const shown = (values, quantity) => {
      const { factor } = units.of(quantity);
      return values.map((value) => (value === null ? null : value / factor));
    };
    const tables = this.lines.map(({ curve, one }) => [
      shown(curve.x, one.panel.x.quantity), shown(curve.y, (curve.right ? panel.right : panel.y).quantity),
    ]);
    return tables.length === 1 ? tables[0] : uPlot.join(sorted(tables));
  }

  /** From where to where x runs, in the units that are shown. */
  range() {
    const { panel } = this.cases[0];
    const { factor } = this.units.of(panel.x.quantity);
    const ends = this.cases.flatMap(({ panel: own }) => own.x.limits
      ?? own.curves.flatMap((curve) => curve.x.filter((x) => !own.x.log || x > 0)));
    return [Math.min(...ends) / factor, Math.max(...ends) / factor];
  }

  /** Show all of x, or what is zoomed into; y follows. */
  fit() {
    if (!this.plot) return;
    const { zoom } = columnOf(this.column);
    const { factor } = this.units.of(this.cases[0].panel.x.quantity);
    const [min, max] = zoom?.map((end) => end / factor) ?? this.range();
    this.plot.setScale("x", { min, max });
  }

  /** Show this range of x, in the units that are shown, in all panels of the column. */
  zoom(ends) {
    const { factor } = this.units.of(this.cases[0].panel.x.quantity);
    zoomTo(this.column, ends.map((end) => end * factor));
  }

  make(key, data, height) {
    const before = this.plot;
    this.plot = null; // what is hovered over is no more
    before?.destroy();
    this.key = key;
    const { ink, soft, line } = colours();
    const { panel } = this.cases[0];
    const rows = panel.strips.length ? this.rows() : null;
    const font = "11px system-ui, sans-serif";
    const axis = (more) => ({
      stroke: soft, font, labelFont: LABEL_FONT, labelSize: 16, grid: { stroke: line, width: 1 },
      ticks: { stroke: line, width: 1, size: 4 }, ...more,
    });
    const values = (_, ticks) => ticks.map((tick) => (tick === null ? "" : digits(tick, 6)));
    const logarithmic = (scale, room) => ({
      splits: (plot, _, min, max) => logTicks(min, max, room(plot) / devicePixelRatio).ticks,
      filter: (plot, ticks) => ticks,
      values: (plot, ticks) => {
        const { labelled } = logTicks(plot.scales[scale].min, plot.scales[scale].max, room(plot) / devicePixelRatio);
        return ticks.map((tick) => (labelled.has(tick) ? digits(tick, 6) : ""));
      },
    });
    const logX = panel.x.log ? logarithmic("x", (plot) => plot.bbox.width) : {};
    const logY = panel.y.log ? logarithmic("y", (plot) => plot.bbox.height) : {};
    const { units } = this;
    const wide = this.place.clientWidth - LEFT - (panel.right ? RIGHT : 20);
    const { y: yAxis } = panel;
    this.plot = new uPlot({
      width: this.place.clientWidth || 320, height, padding: [8, panel.right ? 0 : 20, 0, 0],
      legend: { show: false },
      cursor: {
        drag: { x: true, y: false, setScale: false }, sync: { key: this.column, scales: ["x", null] },
        dataIdx: (plot, series, index) => nearest(plot.data[series] ?? [], plot.data[0], index),
        points: { size: 6 },
      },
      scales: {
        x: { time: false, distr: panel.x.log ? 3 : 1, range: (_, min, max) => [min, max] },
        y: { distr: panel.y.log ? 3 : 1, range: rows ? [0, rows.length] : (_, min, max) => this.tall(min, max, yAxis) },
        ...(panel.right ? { right: { range: (_, min, max) => this.limits("right") ?? padded(min, max) } } : {}),
      },
      axes: [
        axis({ label: rows ? undefined : axisLabel(units, panel.x, wide), size: rows ? 4 : 28, show: !rows, values,
          grid: { show: !rows, stroke: line, width: 1 }, ...logX }),
        rows
          ? axis({ size: LEFT + 16, splits: () => rows.map((_, k) => rows.length - k - 0.5), grid: { show: false },
            ticks: { show: false }, stroke: ink,
            values: () => rows.map(({ one, strip }) => `${one.label} ${strip.face}`.trim()) })
          : axis({ label: axisLabel(units, panel.y, height - MARGIN), size: LEFT, values, ...logY }),
        ...(panel.right ? [axis({ scale: "right", side: 1, label: axisLabel(units, panel.right, height - MARGIN), size: RIGHT, grid: { show: false }, values })] : []),
      ],
      series: [{}, ...(rows ? [{ show: true, stroke: "transparent", points: { show: false } }] : this.lines.map(({ one, curve }) => ({
        scale: curve.right ? "right" : "y", stroke: one.colour ?? colours()[curve.colour] ?? ink,
        width: (one.label && one.pinned ? 0.9 : 1.25) * (curve.width ?? 1.6), alpha: curve.opacity,
        pxAlign: 0, // whole pixels would make steps of a slope
        ...(isDots(curve) ? DOTS : { dash: DASHES[curve.line], points: { show: false } }),
      })))],
      hooks: {
        drawClear: [(plot) => (rows ? null : this.areas(plot))],
        draw: [(plot) => (rows ? this.strips(plot, this.rows()) : this.marks(plot))],
        setCursor: [(plot) => this.hover(plot)],
        setSelect: [(plot) => {
          const { left, width } = plot.select;
          if (width < 6) return;
          this.zoom([plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
          plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
        }],
        ready: [(plot) => plot.over.addEventListener("dblclick", () => zoomTo(this.column, null))],
      },
    }, data, this.place);
    columnOf(this.column).charts.add(this);
    this.fit();
  }

  /** The range of y: of the curves, of the bounds behind them, of the marks. */
  tall(min, max, { from_zero: fromZero }) {
    const { panel } = this.cases[0];
    const { factor } = this.units.of(panel.y.quantity);
    const limits = this.limits("y");
    if (limits) return limits;
    if (panel.y.log && min > 0) return [min / 1.3, max * 1.3]; // a tenth of a decade of room
    let [low, high] = [min ?? 0, max ?? 1];
    if (this.cases.length === 1) {
      for (const area of panel.areas) {
        low = Math.min(low, ...area.low.filter(Number.isFinite).map((v) => v / factor));
        high = Math.max(high, ...area.high.filter(Number.isFinite).map((v) => v / factor));
      }
    }
    for (const mark of panel.marks.filter((one) => one.along === "x")) {
      low = Math.min(low, mark.value / factor);
      high = Math.max(high, mark.value / factor);
    }
    const [least, most] = padded(low, high);
    return fromZero && low >= 0 ? [0, most] : [least, most];
  }

  /** The ends of an axis that hold those of all cases, in the units that are shown; null without. */
  limits(name) {
    const ends = this.cases.map(({ panel }) => panel[name]?.limits).filter(Boolean);
    if (!ends.length) return null;
    const { factor } = this.units.of(this.cases[0].panel[name].quantity);
    return [Math.min(...ends.map(([low]) => low)) / factor, Math.max(...ends.map(([, high]) => high)) / factor];
  }

  inside(plot, draw) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    draw(ctx);
    ctx.restore();
  }

  areas(plot) {
    const { panel } = this.cases[0];
    if (this.cases.length > 1) return;
    const { units } = this;
    const [fx, fy] = [units.of(panel.x.quantity).factor, units.of(panel.y.quantity).factor];
    const point = (x, y) => [plot.valToPos(x / fx, "x", true), plot.valToPos(y / fy, "y", true)];
    this.inside(plot, (ctx) => {
      for (const area of panel.areas) {
        ctx.fillStyle = colours()[shadeOf(area)];
        ctx.beginPath();
        area.x.forEach((x, k) => ctx.lineTo(...point(x, area.high[k])));
        for (let k = area.x.length - 1; k >= 0; k--) ctx.lineTo(...point(area.x[k], area.low[k]));
        ctx.fill();
      }
    });
  }

  marks(plot) {
    const { panel } = this.cases[0];
    const scaleOf = { x: "y", y: "x" };
    this.inside(plot, (ctx) => {
      const { bbox } = plot;
      const ratio = devicePixelRatio;
      const zero = plot.valToPos(0, "y", true);
      const lines = panel.marks.map((mark) => ({ ...mark, plain: !mark.label && mark.value === 0, at: plot.valToPos(
        mark.value / this.units.of(mark.along === "x" ? panel.y.quantity : panel.x.quantity).factor, scaleOf[mark.along], true) }));
      if (zero > bbox.top && zero < bbox.top + bbox.height - 1) lines.push({ along: "x", at: zero, plain: true });
      const [low, high] = [{ x: bbox.top, y: bbox.left }, { x: bbox.top + bbox.height, y: bbox.left + bbox.width }];
      for (const { along, at, label, plain } of lines.filter((one) => one.at >= low[one.along] && one.at <= high[one.along])) {
        ctx.strokeStyle = ctx.fillStyle = colours().soft;
        ctx.textAlign = "left";
        ctx.textBaseline = "alphabetic";
        ctx.lineWidth = ratio;
        ctx.setLineDash(plain ? [] : [4 * ratio, 3 * ratio]);
        ctx.beginPath();
        if (along === "x") { ctx.moveTo(bbox.left, at); ctx.lineTo(bbox.left + bbox.width, at); }
        else { ctx.moveTo(at, bbox.top); ctx.lineTo(at, bbox.top + bbox.height); }
        ctx.stroke();
        if (plain) continue;
        ctx.font = `${11 * ratio}px system-ui, sans-serif`;
        if (along === "x") {
          const above = at - bbox.top > 16 * ratio;
          ctx.fillText(label, bbox.left + 6 * ratio, at + (above ? -4 : 12) * ratio);
        } else {
          const room = at + ctx.measureText(label).width + 8 * ratio < bbox.left + bbox.width;
          ctx.textAlign = room ? "left" : "right";
          ctx.fillText(label, at + (room ? 4 : -4) * ratio, bbox.top + bbox.height - 6 * ratio);
          ctx.textAlign = "left";
        }
      }
    });
  }

  strips(plot, rows) {
    const { panel } = this.cases[0];
    const { factor } = this.units.of(panel.x.quantity);
    this.inside(plot, (ctx) => {
      const ratio = devicePixelRatio;
      const fills = new Map([-1, 0, 1].map((zone) => [zone, hatched(ctx, zone, Math.round(8 * ratio))]));
      rows.forEach(({ strip }, k) => {
        const top = plot.valToPos(rows.length - k - 0.14, "y", true);
        const bottom = plot.valToPos(rows.length - k - 0.86, "y", true);
        for (const [zone, from, to] of strip.runs) {
          const [a, b] = [from, to].map((x) => plot.valToPos(x / factor, "x", true));
          ctx.fillStyle = fills.get(zone);
          ctx.fillRect(a, top, b - a, bottom - top);
          ctx.strokeStyle = colours().soft;
          ctx.lineWidth = ratio * 0.6;
          ctx.strokeRect(a, top, b - a, bottom - top);
        }
      });
    });
  }

  hover(plot) {
    const { panel } = this.cases[0];
    const { left, idxs } = plot.cursor;
    if (left == null || left < 0 || plot !== this.plot) return this.onReading(null);
    const x = plot.posToVal(left, "x");
    if (panel.strips.length) {
      const si = x * this.units.of(panel.x.quantity).factor;
      return this.onReading({ x, values: this.cases.flatMap((one) => one.panel.strips.map((strip) => {
        const run = strip.runs.find(([, from, to]) => si >= from && si <= to);
        return run ? panel.words[run[0] + 1] : "";
      })) });
    }
    return this.onReading({ x, values: this.lines.map((_, k) => {
      const index = idxs?.[k + 1];
      const value = index == null ? null : plot.data[k + 1]?.[index];
      return value == null ? "" : digits(value);
    }) });
  }

  /** Keys: arrows move the reading, + and - zoom, 0 shows all. */
  key_(event) {
    const { plot } = this;
    if (!plot) return;
    const { min, max } = plot.scales.x;
    const at = plot.cursor.left >= 0 ? plot.cursor.left : plot.over.clientWidth / 2;
    const wide = plot.over.clientWidth;
    const step = event.shiftKey ? 40 : 8;
    const zoom = (factor) => {
      const middle = plot.posToVal(at, "x");
      const log = this.cases[0].panel.x.log;
      const by = log ? [middle * (min / middle) ** factor, middle * (max / middle) ** factor]
        : [middle + (min - middle) * factor, middle + (max - middle) * factor];
      const [low, high] = this.range();
      if (by[0] <= low && by[1] >= high) zoomTo(this.column, null);
      else this.zoom([Math.max(low, by[0]), Math.min(high, by[1])]);
    };
    const acts = {
      ArrowLeft: () => plot.setCursor({ left: Math.max(0, at - step), top: 10 }),
      ArrowRight: () => plot.setCursor({ left: Math.min(wide, at + step), top: 10 }),
      "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), 0: () => zoomTo(this.column, null),
      Escape: () => { zoomTo(this.column, null); plot.setCursor({ left: -10, top: -10 }); },
    };
    const act = acts[event.key];
    if (act) { act(); event.preventDefault(); }
  }

  resize(height) {
    const width = this.place.clientWidth;
    if (this.plot && width && (width !== this.plot.width || height !== this.plot.height)) this.plot.setSize({ width, height });
  }

  end() {
    columnOf(this.column).charts.delete(this);
    this.plot?.destroy();
    this.plot = null;
  }
}

/** The name of the colour of an area. */
const shadeOf = ({ shade }) => (shade.startsWith("shade") ? shade : `shade-${shade}`);

/** uPlot.join wants every x to rise. */
function sorted(tables) {
  return tables.map(([x, y]) => {
    if (x.length < 2 || x[0] <= x[x.length - 1]) return [x, y];
    return [[...x].reverse(), [...y].reverse()];
  });
}

/** The nearest point at which a series has a value. */
function nearest(values, x, index) {
  if (index == null || values[index] != null) return index;
  let [below, above] = [index, index];
  while (below >= 0 && values[below] == null) below--;
  while (above < values.length && values[above] == null) above++;
  if (below < 0) return above < values.length ? above : null;
  if (above >= values.length) return below;
  return x[index] - x[below] <= x[above] - x[index] ? below : above;
}

const DIGITS = [1, 2, 3, 4, 5, 6, 7, 8, 9];
const FEW = [1, 2, 5];
const GAP = 44; // [px] from one label to the next

/** Ticks of a logarithmic axis, and those of them that have room for a label. */
function logTicks(min, max, width) {
  const decades = Math.log10(max / min);
  const room = width / decades; // of a decade
  const powers = [];
  for (let power = Math.floor(Math.log10(min)); power <= Math.log10(max); power++) powers.push(power);
  const inside = (numbers, of) => of.flatMap((power) => numbers.map((digit) => Number(`${digit}e${power}`))).filter((tick) => tick >= min && tick <= max);
  if (decades < 1) { // as on a linear axis, as many as have room
    const apart = (ticks) => ticks.length > 1 && ticks.slice(1).every((tick, k) => room * Math.log10(tick / ticks[k]) > GAP);
    const ticks = [8, 6, 4, 3, 2].map((count) => niceTicks(min, max, count)).find(apart) ?? inside(FEW, powers);
    return { ticks, labelled: new Set(ticks) };
  }
  const every = Math.max(1, Math.ceil(GAP / room));
  return {
    ticks: inside(DIGITS, powers),
    labelled: new Set(inside(room > 4 * GAP ? FEW : [1], powers.filter((power) => power % every === 0))),
  };
}

function padded(min, max) {
  if (min == null) return [0, 1];
  const room = (max - min) * 0.06 || Math.abs(max) * 0.05 || 1;
  return [min - room, max + room];
}

const SWATCH = { solid: "", dashed: "7 3", dashdot: "8 2 2 2", dotted: "2 3" };

/** The entry of a curve in a legend: its line, or a point. */
export function Swatch({ curve, colour }) {
  const style = { stroke: colour ?? `var(--${curve.colour})` };
  return html`<svg class="swatch" width="26" height="8" aria-hidden="true">${isDots(curve)
    ? html`<circle cx="13" cy="4" r="3" fill="none" style=${style} stroke-width="1.5" />`
    : html`<line x1="1" x2="25" y1="4" y2="4" style=${style} stroke-width=${1.4 * (curve.width ?? 1.6)} opacity=${curve.opacity} stroke-dasharray=${SWATCH[curve.line]} />`}</svg>`;
}

/** A panel with its legend, in which the values under the pointer stand. */
export function Panel({ title, cases, units, height, theme, description }) {
  const place = useRef(null);
  const chart = useRef(null);
  const legend = useRef(null);
  const { panel } = cases[0];
  const tall = panel.strips.length ? 18 + 24 * cases.reduce((n, one) => n + one.panel.strips.length, 0) : height;

  useLayoutEffect(() => {
    chart.current = new Chart(place.current, (reading) => showIn(legend.current, reading));
    const watch = new ResizeObserver(() => chart.current?.resize(chart.current.tall_));
    watch.observe(place.current);
    const sight = new IntersectionObserver((entries) => chart.current?.look(entries.at(-1).isIntersecting), { rootMargin: "120px" });
    sight.observe(place.current);
    const print = () => chart.current?.look(true);
    addEventListener("beforeprint", print);
    return () => { removeEventListener("beforeprint", print); sight.disconnect(); watch.disconnect(); chart.current.end(); chart.current = null; };
  }, []);
  useLayoutEffect(() => {
    chart.current.tall_ = tall;
    chart.current.show(cases, units, tall);
  });
  const painted = useRef(theme);
  useEffect(() => { // by now the page has forgotten the colours of the theme before
    if (painted.current !== theme) chart.current.show(cases, units, tall);
    painted.current = theme;
  }, [theme]);

  const several = cases.length > 1;
  const lines = linesOf(cases);
  return html`<figure class="panel" data-panel=${panel.name}>
    <figcaption>
      <h3>${title}</h3>
      <div class="legend" ref=${legend}>
        <span class="at" data-axis=${`${panel.x.label}`} data-unit=${units.text(panel.x.quantity)}></span>
        ${lines.map(({ one, curve }, k) => curve.in_legend && html`<span class="entry" key=${k}>
          <${Swatch} curve=${curve} colour=${one.colour} />
          ${several && html`<b>${one.label} </b>`}<span class="symbol"><${Symbol} of=${curve.symbol} /></span> ${several && curve.symbol ? "" : html`<span><${Words} of=${units.sentence(curve.label)} /></span>`}
          <output class="value" data-value=${k}></output></span>`)}
        ${!several && panel.areas.filter((area) => area.label).map((area) => html`<span class="entry"><span class=${`patch ${shadeOf(area)}`}></span>
          ${area.symmetrical ? html`<span class="symbol">±<${Symbol} of=${area.label} /></span>` : area.label}</span>`)}
        ${panel.strips.length > 0 && html`${panel.words.map((word, k) => html`<span class="entry"><span class=${`patch zone${k - 1}`}></span>${word}</span>`)}
          ${cases.flatMap((one) => one.panel.strips).map((_, k) => html`<output class="value" data-value=${k} hidden></output>`)}`}
      </div>
    </figcaption>
    <div class="plot" ref=${place} tabindex="0" role="img" aria-label=${description}
      onKeyDown=${(event) => chart.current?.key_(event)}></div>
  </figure>`;
}

function showIn(legend, reading) {
  if (!legend) return;
  const at = legend.querySelector(".at");
  at.textContent = reading ? `${digits(reading.x, 4)} ${at.dataset.unit}` : "";
  for (const place of legend.querySelectorAll("[data-value]")) {
    const value = reading?.values[Number(place.dataset.value)] ?? "";
    if (place.textContent !== value) place.textContent = value;
  }
}
