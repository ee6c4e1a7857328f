// The nip drawn to scale: the whole of roll and drum, and the nip through a lens.
import { html } from "./html.js";
import { T } from "./texts.js";
import { digits, LENGTH } from "./units.js";

const WHOLE = { width: 190, height: 330 };
const NAMES = 38; // height above the upper and below the lower body for their names and radii
const LENS = { width: 270, height: 330 };

/** Hatches of the zones and of rigid bodies, by pattern as well as by colour. */
export function Patterns() {
  return html`<svg width="0" height="0" class="patterns" aria-hidden="true"><defs>
    ${[["faster", "M-2 10 10-2M-2 2 2-2M6 10 10 6"], ["slower", "M-2-2 10 10M6-2 10 2M-2 6 2 10"], ["rigid", "M-2 10 10-2M-2 2 2-2M6 10 10 6"]]
    .map(([name, path]) => html`<pattern id=${`hatch-${name}`} width="8" height="8" patternUnits="userSpaceOnUse">
      <rect width="8" height="8" class=${`zone-${name}`} /><path d=${path} class="hatch-line" /></pattern>`)}
  </defs></svg>`;
}

export function Drawing({ result, units, catalogue }) {
  const { geometry } = result;
  if (!geometry?.bodies?.length) return null;
  const size = (value, unit = LENGTH) => `${digits(units.shown(unit, value), 4)} ${units.text(unit)}`;
  return html`<div class="drawing">
    <${Whole} ...${{ result, geometry, size }} />
    ${geometry.half_width && geometry.bodies.length > 1 && html`<${Lens} ...${{ result, geometry, size, unit: units.of(LENGTH).factor }} />`}
  </div>`;
}

// ---- roll and drum ----

function Whole({ result, geometry, size }) {
  const [upper, lower] = geometry.bodies;
  const wide = Math.max(upper.radius, lower?.radius ?? 0) * 1.12;
  const top = -2 * upper.radius;
  const bottom = 2 * (lower?.radius ?? 0);
  const scale = Math.min((WHOLE.width - 24) / (2 * wide), (WHOLE.height - NAMES * (lower ? 2 : 1)) / (bottom - top));
  const x = (value) => WHOLE.width / 2 + value * scale;
  const y = (value) => NAMES + (value - top) * scale;
  const words = T.drawing.whole(T.bodies[upper.name] ?? upper.name, size(upper.radius),
    lower && (T.bodies[lower.name] ?? lower.name), lower && size(lower.radius));
  return html`<svg class="scaled" viewBox=${`0 0 ${WHOLE.width} ${WHOLE.height}`} role="img" aria-label=${words}>
    <${Body} body=${upper} cx=${x(0)} cy=${y(-upper.radius)} scale=${scale} side="roll" size=${size} up=${true} />
    ${lower && html`<${Body} body=${lower} cx=${x(0)} cy=${y(lower.radius)} scale=${scale} side="drum" size=${size} />`}
    ${geometry.web && lower && html`<${WebPath} ...${{ geometry, result, x, y, scale }} />`}
  </svg>`;
}

function Body({ body, cx, cy, scale, side, size, up }) {
  const rings = [];
  let radius = body.radius;
  for (const layer of body.layers ?? []) {
    rings.push(radius);
    radius -= layer.thickness;
  }
  const core = body.rigid || body.deep ? 0 : Math.max(radius, 0);
  if (!rings.length) rings.push(body.radius);
  const label = T.bodies[body.name] ?? body.name;
  const edge = cy + (up ? -1 : 1) * body.radius * scale;
  const base = up ? edge - 22 : edge + 19; // outside the body: inside are hatches and arrows
  return html`<g>
    ${rings.map((ring, k) => html`<circle cx=${cx} cy=${cy} r=${Math.max(ring * scale - (k ? 0.8 : 0), 0.5)}
      class=${`body ${side} layer${k % 3}${body.rigid ? " rigid" : ""}`} />`)}
    ${core > 0 && html`<circle cx=${cx} cy=${cy} r=${core * scale} class=${`core ${body.core ?? ""}`} />`}
    <path d=${`M${cx - 4} ${cy}h8M${cx} ${cy - 4}v8`} class="centre" />
    <text x=${cx} y=${base} class="name">${label}</text>
    <text x=${cx} y=${base + 14} class="radius">R ${size(body.radius)}${body.rigid ? `, ${T.drawing.rigid}` : ""}</text>
  </g>`;
}

/** The web: onto the drum's arc, through the nip, around the roll; where it slips behind the nip. */
function WebPath({ geometry, result, x, y, scale }) {
  const [roll, drum] = geometry.bodies;
  const before = geometry.drum_wrap ?? 0;
  const behind = geometry.roll_wrap ?? 0;
  const on = (body, sign, angle) => [ // an angle from the nip, seen from the body's centre
    x(body.radius * Math.sin(angle)), y(sign * body.radius * (1 - Math.cos(angle))),
  ];
  const [ax, ay] = on(drum, 1, -before);
  // it ends where the name of the drum begins
  const away = Math.min(160, before > 0 && before < Math.PI ? (y(2 * drum.radius) + 4 - ay) / Math.sin(before) : 160);
  const from = [ax - away * Math.cos(before), ay + away * Math.sin(before)];
  const path = [`M${from}L${ax} ${ay}`];
  if (before) path.push(`A${drum.radius * scale} ${drum.radius * scale} 0 ${before > Math.PI ? 1 : 0} 1 ${on(drum, 1, 0)}`);
  const arc = (end) => `A${roll.radius * scale} ${roll.radius * scale} 0 ${end > Math.PI ? 1 : 0} 0 ${on(roll, -1, end)}`;
  if (behind) path.push(arc(Math.min(behind, Math.PI * 0.999)));
  else path.push(`L${x(roll.radius)} ${y(0)}`);
  const slip = result.outputs.slip_angle?.value;
  const turns = (cx, cy, r, start, end, sweep) => {
    const p = (angle) => `${cx + r * Math.cos(angle)} ${cy + r * Math.sin(angle)}`;
    return `M${p(start)}A${r} ${r} 0 0 ${sweep} ${p(end)}`;
  };
  return html`<g>
    <path d=${path.join("")} class="web" />
    ${slip > 0 && behind > 0 && html`<path d=${`M${on(roll, -1, 0)}${arc(Math.min(slip, behind))}`} class="web slips" />`}
    <path d=${turns(x(0), y(-roll.radius), 0.8 * roll.radius * scale, 0.5, -0.5, 0)} class="turn" marker-end="" />
    <${Arrow} at=${[x(0) + 0.8 * roll.radius * scale * Math.cos(-0.5), y(-roll.radius) + 0.8 * roll.radius * scale * Math.sin(-0.5)]} angle=${-0.5 - Math.PI / 2} />
    <path d=${turns(x(0), y(drum.radius), 0.8 * drum.radius * scale, -0.5, 0.5, 1)} class="turn" />
    <${Arrow} at=${[x(0) + 0.8 * drum.radius * scale * Math.cos(0.5), y(drum.radius) + 0.8 * drum.radius * scale * Math.sin(0.5)]} angle=${0.5 + Math.PI / 2} />
  </g>`;
}

function Arrow({ at: [px, py], angle }) {
  const turn = (angle * 180) / Math.PI;
  return html`<path d="M5 0-4 3.5-2 0-4-3.5z" class="arrow" transform=${`translate(${px} ${py}) rotate(${turn})`} />`;
}

// ---- the nip through a lens ----

function Lens({ result, geometry, size, unit }) {
  const { half_width: a, web } = geometry;
  const [upper, lower] = geometry.bodies;
  const reach = 1.32 * a;
  const scale = LENS.width / (2 * reach);
  const x = (value) => LENS.width / 2 + value * scale;
  const middle = LENS.height / 2;
  const thick = web ? web.thickness * scale : 0;
  const drawn = web ? Math.max(thick, 2.5) : 0;
  // between the edges the surfaces lie on each other, as round as the stiffer one; outside they part
  const share = upper.rigid === lower.rigid ? 0.5 : lower.rigid ? 0 : 1; // of the roll's roundness
  const both = 1 / upper.radius + 1 / lower.radius;
  const contact = (s) => ((1 - share) / lower.radius - share / upper.radius) * (s * s) / 2;
  const gap = (s) => {
    const t = Math.abs(s) / a;
    return t <= 1 ? 0 : (a * a * both / 2) * (t * Math.sqrt(t * t - 1) - Math.acosh(t));
  };
  const steps = Array.from({ length: 81 }, (_, k) => -reach + (2 * reach * k) / 80);
  const face = (sign) => (s) => middle + scale * (contact(s) + (sign < 0 ? -(1 - share) : share) * gap(s)) + sign * drawn / 2;
  const line = (of) => steps.map((s) => `${x(s).toFixed(2)} ${of(s).toFixed(2)}`).join("L");
  const [above, below] = [face(-1), face(1)];
  const strips = result.panels.find((panel) => panel.strips.length)?.strips ?? [];
  const band = 13;
  const zones = (strip, of, sign) => strip.runs.map(([zone, from, to]) => {
    const ends = [from, (from + to) / 2, to];
    const outer = ends.map((s) => `${x(s)} ${of(s) + sign * band}`).reverse();
    return html`<path d=${`M${ends.map((s) => `${x(s)} ${of(s)}`).join("L")}L${outer.join("L")}z`}
      class=${`zone zone${zone}`} />`;
  });
  const faces = strips.length > 1 ? [[strips[0], above, -1], [strips[1], below, 1]] : strips.map((strip) => [strip, above, -1]);
  const offset = geometry.offset ?? 0;
  const centres = x(-offset);
  const label = (body) => T.bodies[body.name] ?? body.name;
  return html`<svg class="scaled lens" viewBox=${`0 0 ${LENS.width} ${LENS.height}`} role="img"
      aria-label=${T.drawing.lens(size(2 * a))}>
    <path d=${`M0 0L${line(above)}L${LENS.width} 0z`} class=${`body roll layer0${upper.rigid ? " rigid" : ""}`} />
    <path d=${`M0 ${LENS.height}L${line(below)}L${LENS.width} ${LENS.height}z`} class=${`body drum layer0${lower.rigid ? " rigid" : ""}`} />
    ${[[upper, -1, above], [lower, 1, below]].map(([body, sign, of]) => body.layers.reduce(([depth, lines], layer) => {
      const deep = depth + layer.thickness * scale;
      return [deep, [...lines, html`<path d=${`M${line((s) => of(s) + sign * deep)}`} class="layer-line" />`]];
    }, [0, []])[1])}
    ${web && html`<path d=${`M${line(above)}L${steps.slice().reverse().map((s) => `${x(s).toFixed(2)} ${below(s).toFixed(2)}`).join("L")}z`} class="web-body" />`}
    ${faces.map(([strip, of, sign]) => zones(strip, of, sign))}
    <path d=${`M${centres} 26V${middle - 72}M${centres} ${middle - 54}V${LENS.height - 26}`} class="centre-line" />
    <text x=${LENS.width / 2} y="20" class="name">${label(upper)}</text>
    <text x=${LENS.width / 2} y=${LENS.height - 10} class="name">${label(lower)}</text>
    <g class="dimension">
      <path d=${`M${x(-a)} ${middle - 22 - band}V${middle - 58}M${x(a)} ${middle - 22 - band}V${middle - 58}M${x(-a)} ${middle - 52}H${x(a)}`} />
      <${Arrow} at=${[x(-a) + 5, middle - 52]} angle=${Math.PI} /><${Arrow} at=${[x(a) - 5, middle - 52]} angle=${0} />
      <text x=${LENS.width / 2} y=${middle - 58}>2a = ${size(2 * a)}</text>
    </g>
    ${web && html`<g class="dimension"><path d=${`M14 ${middle + 62}h44`} /><${Arrow} at=${[62, middle + 62]} angle=${0} />
      <text x="14" y=${middle + 78} class="start">${T.drawing.web} ${size(web.thickness, { unit: "m", shown_unit: "um" })}</text>
      ${drawn > thick + 0.3 && html`<text x="14" y=${middle + 92} class="start">(${T.drawing.thicker})</text>`}</g>`}
    <${Bar} scale=${scale} size=${size} unit=${unit} />
  </svg>`;
}

/** A bar of a round length: the drawing's scale. */
function Bar({ scale, size, unit }) {
  const power = 10 ** Math.floor(Math.log10(110 / (scale * unit)));
  const length = unit * [5, 2, 1].map((n) => n * power).find((one) => one * scale * unit <= 110);
  const end = LENS.width - 12;
  const y = LENS.height / 2 + 62;
  return html`<g class="dimension"><path d=${`M${end - length * scale} ${y - 4}v8M${end} ${y - 4}v8M${end - length * scale} ${y}H${end}`} />
    <text x=${end} y=${y + 16} class="end">${size(length)}</text></g>`;
}
