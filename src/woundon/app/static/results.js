// The results of a case: numbers with errors, certificate, warnings, panels, differences.
import { at, same } from "./cases.js";
import { colourOf, linesOf, newCurve, newPanel, Panel, tablesOf } from "./chart.js";
import { Drawing } from "./drawing.js";
import { Fragment, html, useEffect, useMemo, useRef, useState } from "./html.js";
import { isPlane, Plane } from "./plane.js";
import { Label, Symbol, symbolText, wordsText } from "./symbols.js";
import { T } from "./texts.js";
import { digits, typeset } from "./units.js";
import { headlines } from "./variables.js";

const BARS = 9;
const ERRORS = 3; // that are listed
const ROWS = 33; // of a table of a panel

// ---- numbers ----

const ROUNDING = 1e-14; // [SI]: smaller values within their errors are zero, as the offset of equal rollers

/** The value of an output as it is shown. */
function valueOf({ value, error }) {
  return Math.abs(value) < ROUNDING && Math.abs(value) <= Math.abs(error ?? 0) ? 0 : value;
}

export function errorText(units, output, { value, error }) {
  if (error == null || (error === 0 && value === 0)) return "";
  const shown = Math.abs(units.shown(output, error));
  const size = Math.abs(units.shown(output, value));
  const last = size ? 10 ** (Math.floor(Math.log10(size)) - 4) : 0;
  return shown < last ? `± < ${digits(last, 1)}` : `± ${digits(shown, 2)}`;
}

/** The answer in the first line, as the reports have it, in the shown units. */
function answerText({ units, kind, state: { result } }) {
  if (result.headline.length) {
    const values = result.headline.map(({ name, words }) => {
      const output = kind.outputs.find((one) => one.name === name);
      return `${words} ${digits(units.shown(output, valueOf(result.outputs[name])), 4)} ${units.text(output)}`.trim();
    }).join(", ");
    return values[0].toUpperCase() + values.slice(1);
  }
  const [total, added] = ["wound_on_tension", "nip_induced_tension"].map((name) => kind.outputs.find((output) => output.name === name && !output.array));
  const web = result.problem.web_tension;
  if (!total || !added || typeof web !== "number") return units.sentence(result.answer[0] ?? "");
  const value = (si) => `${digits(Number(units.shown(total, si).toPrecision(4)))} ${units.text(total)}`;
  return T.results.sum(...[result.outputs[total.name].value, web, result.outputs[added.name].value].map(value));
}

function difference(units, output, from, to) {
  if (from == null || to == null) return "–";
  const value = units.shown(output, to) - units.shown(output, from);
  return (value > 0 ? "+" : "") + digits(Number(value.toPrecision(4)), 4);
}

/** The answer, and below it what to change in a winding, or what the entrained air reduces. */
function Answer({ store }) {
  const { answer, kind } = store.state.result;
  const more = kind === "winding" ? answer.slice(1, -1) : answer.slice(1);
  return html`<p class="answer">${answerText(store)}</p>${more.map((line) => html`<p class="advice" key=${line}>${store.units.sentence(line)}</p>`)}`;
}

export function Numbers({ store }) {
  const { units, kind, state } = store;
  const { result } = state;
  return html`<section class="numbers" aria-label=${T.results.numbers}>
    ${headlines(kind, result).map((output) => {
      const entry = result.outputs[output.name];
      return html`<div class=${`number-card${kind.main.includes(output.name) ? " main" : ""}`} key=${output.name} data-output=${output.name}
          title=${output.label}>
        <div class="what"><span class="symbol"><${Symbol} of=${output.symbol} /></span> <${Label} of=${output.label} /></div>
        <div class="much"><output class="value" data-si=${entry.value}>${digits(units.shown(output, valueOf(entry)))}</output>
          <span class="unit">${units.text(output)}</span></div>
        <div class="error" title=${T.results.error}>${errorText(units, output, entry)}</div>
        ${store.pinned.map((pin) => html`<div class=${`versus pin-${pin.label}`} key=${pin.label}><b>${pin.label}</b>
          ${digits(units.shown(output, pin.result.outputs[output.name]?.value))}</div>`)}
      </div>`;
    })}
  </section>`;
}

/** The errors of the case, and whose results are shown. */
function Errors({ store, consequence }) {
  const errors = store.errors.slice(0, ERRORS);
  return html`<div class="notice wrong" role="alert">${errors.map(({ label, text }) => html`<p>${label && html`<b>${label}: </b>`}${text}</p>`)}<p>${consequence}</p></div>`;
}

/** In place of results that the case does not have: its errors, or the progress of the solver. */
export function Pending({ store }) {
  return store.errors.length ? html`<${Errors} store=${store} consequence=${T.results.none} />` : html`<p class="quiet">${T.results.busy}</p>`;
}

/** Answer, certificate and warnings; if the case has errors, those of the last valid case, marked as such. */
export function Verdict({ store }) {
  const { certificate, warnings } = store.state.result;
  const wrong = store.errors.length > 0;
  const [style, mark] = wrong ? ["earlier", "–"] : certificate.ok ? ["good", "✓"] : ["bad", "✗"];
  return html`<${Fragment}>
    ${wrong && html`<${Errors} store=${store} consequence=${T.results.shown} />`}
    <${Answer} store=${store} />
    <details class=${`certificate ${style}`}>
      <summary><span class="mark" aria-hidden="true">${mark}</span> ${wrong && `${T.results.earlier} `}${certificate.text}</summary>
      <table><caption>${T.results.conditions}</caption><thead><tr><th scope="col">${T.results.condition}</th><th scope="col">${T.results.violation}</th></tr></thead>
        <tbody>${Object.entries(certificate.conditions).map(([condition, value]) => html`<tr><th scope="row">${condition.replaceAll("_", " ")}</th>
          <td>${value == null ? "–" : value.toExponential(1)}</td></tr>`)}</tbody></table>
    </details>
    ${warnings.length > 0 && html`<details class="warnings" open=${warnings.length < 3}><summary><span class="mark" aria-hidden="true">!</span> ${T.results.warnings} (${warnings.length})</summary>
      <ul>${warnings.map((text) => html`<li key=${text}>${store.units.sentence(text)}</li>`)}</ul></details>`}
  <//>`;
}

// ---- panels ----

/** The states that are drawn over each other: the live one first. */
export function states(store, panelOf) {
  const live = { label: "", colour: null, panel: panelOf(store.state) };
  const pins = store.pinned.map((pin) => ({ label: pin.label, pinned: true, colour: colourOf(`pin-${pin.label}`), panel: panelOf(pin) }))
    .filter((one) => one.panel);
  if (!pins.length) return [live];
  return [{ ...live, label: T.compare.live, colour: colourOf("live") }, ...pins];
}

export function Panels({ store }) {
  const { result } = store.state;
  return html`<div class="panels">
    <figure class="panel drawing-panel" data-panel="drawing"><figcaption><h3>${T.drawing.title}</h3></figcaption>
      <${Drawing} result=${result} units=${store.units} catalogue=${store.catalogue} /></figure>
    ${cells(result.panels).map((cell) => html`<div class="panel-cell" key=${cell[0].name}>${cell.map((panel) => html`<${OnePanel}
      key=${panel.name} store=${store} name=${panel.name} cases=${states(store, (state) => state.result.panels.find((one) => one.name === panel.name))} />`)}</div>`)}
    <${SlowPanels} store=${store} />
    <${Curve} store=${store} />
    <${Bars} store=${store} />
  </div><${MorePanels} store=${store} />`;
}

const OTHERS = "outputs"; // group of the panels of arrays that no other panel shows

/** The panels that are computed at rest; stale while the case changes. */
export function SlowPanels({ store }) {
  return html`<${LatePanels} store=${store} chosen=${(panel) => panel.group !== OTHERS} />`;
}

/** The other arrays, drawn when the reader opens them. */
export function MorePanels({ store }) {
  const [open, setOpen] = useState(false);
  const { answer } = store.extra("report");
  const isOther = (panel) => panel.group === OTHERS;
  if (answer && !answer.slow_panels?.some(isOther)) return null;
  return html`<details class="more" onToggle=${(event) => setOpen(event.target.open)}><summary>${T.panels.more}</summary>
    ${open && (answer ? html`<div class="panels"><${LatePanels} store=${store} chosen=${isOther} /></div>` : html`<p class="quiet">${T.results.busy} …</p>`)}</details>`;
}

function LatePanels({ store, chosen }) {
  const { answer, stale } = store.extra("report");
  const panelsOf = (state) => (state.extras.report?.kind === store.kind.name && state.extras.report.answer?.slow_panels) || [];
  return (answer?.slow_panels ?? []).filter(chosen).map((panel) => html`<div class=${`panel-cell${stale ? " stale" : ""}`} key=${panel.name}><${OnePanel}
    store=${store} name=${panel.name} cases=${states(store, (state) => panelsOf(state).find((one) => one.name === panel.name))} /></div>`);
}

/** A strip of zones stands below the first panel. */
function cells(panels) {
  return panels.reduce((all, panel) => {
    if (panel.strips.length && all.length) all[0].push(panel);
    else all.push([panel]);
    return all;
  }, []);
}

export function OnePanel({ store, name, cases, title, height = 200, tables = store.state.tables }) {
  const words = store.units.sentence(title ?? cases[0].panel.title);
  const shown = words.charAt(0).toUpperCase() + words.slice(1);
  const lines = cases[0].panel.curves.map((curve) => `${symbolText(curve.symbol)} ${wordsText(curve.label)}`).join(", ");
  const Drawn = isPlane(cases[0].panel) ? Plane : Panel;
  return html`<div class=${`cell cell-${name}`}>
    <${Drawn} title=${shown} cases=${cases} units=${store.units} height=${height} theme=${store.state.theme}
      description=${T.panels.describe(shown, lines || cases[0].panel.strips.map((one) => one.face).join(", "))} />
    ${tables && html`<${Table} store=${store} title=${shown} cases=${cases} />`}
  </div>`;
}

/** The curves of a panel as tables. */
function Table({ store, title, cases }) {
  const { units } = store;
  const { panel } = cases[0];
  if (panel.strips.length) {
    return html`<div class="table-scroll" tabindex="0"><table><caption>${title}</caption>
      <thead><tr><th scope="col"></th><th scope="col">${T.study.from} [${units.text(panel.x.quantity)}]</th><th scope="col">${T.study.to} [${units.text(panel.x.quantity)}]</th><th scope="col">${T.panels.zones}</th></tr></thead>
      <tbody>${cases.flatMap(({ label, panel: own }) => own.strips.flatMap((strip) => strip.runs.map(([zone, from, to]) => html`<tr>
        <th scope="row">${label} ${strip.face}</th><td>${digits(units.shown(own.x.quantity, from), 4)}</td><td>${digits(units.shown(own.x.quantity, to), 4)}</td>
        <td>${panel.words[zone + 1]}</td></tr>`)))}</tbody></table></div>`;
  }
  return tablesOf(linesOf(cases)).map(({ x, axis, columns }) => {
    const step = Math.max(1, Math.ceil(x.length / ROWS));
    const rows = x.map((_, k) => k).filter((k) => k % step === 0 || k === x.length - 1);
    return html`<div class="table-scroll" tabindex="0"><table><caption>${title}</caption><thead><tr><th scope="col">${units.label(axis.label, axis.quantity)}</th>
      ${columns.map(({ one: { label }, curve, axis: own }) => html`<th scope="col">${label} ${symbolText(curve.symbol)} ${wordsText(curve.label)} ${units.text(own.quantity) && `[${units.text(own.quantity)}]`}</th>`)}</tr></thead>
      <tbody>${rows.map((k) => html`<tr><th scope="row">${digits(units.shown(axis.quantity, x[k]), 4)}</th>
        ${columns.map(({ curve, axis: own }) => html`<td>${digits(units.shown(own.quantity, curve.y[k]), 5)}</td>`)}</tr>`)}</tbody></table></div>`;
  });
}

// ---- around the working point: asked for when it comes into sight ----

function useInSight(store, name) {
  const place = useRef(null);
  useEffect(() => {
    if (!place.current) return undefined;
    const watch = new IntersectionObserver((entries) => store.want(name, entries.at(-1).isIntersecting));
    watch.observe(place.current);
    return () => { watch.disconnect(); store.want(name, false); };
  }, [store, name, place.current]);
  return place;
}

const COLOURS = ["roll", "drum", "web"];
const LINES = ["solid", "dashed", "dashdot"];

function curvePanel(store, kind, answer) {
  const names = Object.keys(answer.outputs);
  const field = store.catalogue.forms[kind.form].fields.find((one) => one.name === answer.field);
  const first = store.output(names[0], kind);
  return newPanel({
    name: "curve", x: { label: field.label, quantity: field, limits: [answer.values[0], answer.values.at(-1)] },
    y: { label: names.length > 1 ? T.panels.tensions : first.label.split(",")[0], quantity: first },
    marks: [{ along: "y", value: answer.at, label: "" }],
    curves: names.map((name, k) => newCurve({
      name, symbol: store.output(name, kind).symbol, colour: COLOURS[k % 3], line: LINES[k % 3], x: answer.values, y: answer.outputs[name],
    })),
  });
}

function Curve({ store }) {
  const { kind } = store;
  const place = useInSight(store, "curve");
  const { answer, stale } = store.extra("curve");
  if (!store.loadOf(kind)) return null;
  if (!answer || !at(store.state.case, answer.field)) return html`<div class="curve-cell" ref=${place}><p class="quiet waits">${T.panels.waits}</p></div>`;
  const cases = states(store, (state) => state.extras.curve?.kind === kind.name && state.extras.curve.answer && curvePanel(store, kind, state.extras.curve.answer));
  const label = cases[0].panel.x.label;
  return html`<div class=${`curve-cell${stale ? " stale" : ""}`} ref=${place}><${OnePanel} store=${store} name="curve" cases=${cases} title=${T.panels.curve(cases[0].panel.y.label, label)} /></div>`;
}

/** By how much the answer changes for one percent more of each field. */
function Bars({ store }) {
  const place = useInSight(store, "bars");
  const [chosen, choose] = useState(null);
  const { answer: bars, stale } = store.extra("bars");
  if (!store.loadOf(store.kind)) return null;
  if (!bars?.parameters?.length) return html`<div class="bars" ref=${place}><p class="quiet waits">${T.panels.waits}</p></div>`;
  const row = Math.max(0, bars.outputs.indexOf(chosen));
  const output = store.output(bars.outputs[row]);
  const rows = bars.parameters.map((name, k) => ({ name, value: bars.elasticities[row][k] }))
    .filter((one) => Number.isFinite(one.value) && one.value !== 0)
    .sort((a, b) => Math.abs(b.value) - Math.abs(a.value)).slice(0, BARS);
  const most = Math.max(...rows.map((one) => Math.abs(one.value)), 1e-12);
  return html`<figure class=${`panel bars${stale ? " stale" : ""}`} data-panel="bars" ref=${place}>
    <figcaption><h3>${T.panels.bars}</h3>
      <label class="inline"><span class="hidden">${T.study.output}</span><select value=${output.name} onChange=${(event) => choose(event.target.value)}>
        ${bars.outputs.map((name) => html`<option value=${name} selected=${name === output.name}>${store.output(name).label}</option>`)}</select></label>
    </figcaption>
    <p class="quiet">${T.panels.barsOf(symbolText(output.symbol))}</p>
    <table class="bar-table"><caption class="hidden">${T.panels.bars}</caption><tbody>${rows.map(({ name, value }) => html`<tr key=${name}>
      <th scope="row">${name}</th>
      <td class="bar-cell"><span class="bar-track"><span class=${`bar ${value < 0 ? "less" : "more"}`} style=${{ width: `${(50 * Math.abs(value)) / most}%` }}></span></span></td>
      <td class="bar-value">${value > 0 ? "+" : ""}${digits(value, 2)}</td></tr>`)}</tbody></table>
  </figure>`;
}

// ---- the report's sections ----

export function Sections({ store }) {
  const { answer: report, stale } = store.extra("report");
  return useMemo(() => report?.sections && html`<details class=${`sections${stale ? " stale" : ""}`} open>
    <summary>${T.results.report}</summary>
    <div class="section-grid">${report.sections.map((section) => html`<section key=${section.title}><h3><${Label} of=${section.title} /></h3>
      <table><tbody>${section.rows.map((row, k) => html`<tr key=${k}><th scope="row"><${Label} of=${row.label} /></th><td class="symbol"><${Symbol} of=${row.symbol} /></td>
        <${SectionValue} store=${store} row=${row} /><td class="note">${store.units.sentence(row.note.replace(/^,\s*/, ""))}</td></tr>`)}</tbody></table>
      ${section.text && html`<p>${store.units.sentence(section.text)}</p>`}</section>`)}</div>
  </details>`, [report, stale, store.units]);
}

/** A row of the report in the chosen units. */
function SectionValue({ store, row }) {
  const entry = Object.entries(store.catalogue.units).find(([, known]) => known.some((unit) => unit.name === row.unit));
  const valueText = row.value_text.replace(/^-/, "−");
  if (typeof row.value !== "number" || !entry || !row.unit) return html`<td class="value">${valueText} ${row.error_text && `± ${row.error_text}`}</td><td class="unit-cell">${typeset(row.unit)}</td>`;
  const quantity = { unit: entry[0], shown_unit: row.unit };
  const { factor } = entry[1].find((unit) => unit.name === row.unit);
  const ratio = factor / store.units.of(quantity).factor;
  const error = row.error_text && (row.error_text.startsWith("<") ? `<${digits(Number(row.error_text.slice(1)) * ratio, 1)}` : digits(Number(row.error_text) * ratio, 2));
  return html`<td class="value">${ratio === 1 ? valueText : digits(row.value * ratio)} ${error && `± ${error}`}</td><td class="unit-cell">${store.units.text(quantity)}</td>`;
}

// ---- pinned states ----

/** The pinned states, and the switch of the tables below the panels. */
export function Pins({ store }) {
  const { pins, tables } = store.state;
  return html`<div class="bar-row"><div class="pins" role="group" aria-label=${T.compare.title}>
    <button type="button" class="pin" onClick=${() => store.pin()} disabled=${store.full} title=${store.full ? T.compare.full : ""}>
      <svg viewBox="0 0 16 16" width="14" height="14" aria-hidden="true"><path d="M9.5 1.5 14.5 6.5l-2 .5-2.5 2.5.2 3.3-1 .9-6-6 .9-1 3.3.2L9.9 4.4z M5 11l-3.5 3.5" fill="none" stroke="currentColor" stroke-width="1.4" stroke-linejoin="round" /></svg>
      ${T.compare.pin}</button>
    ${store.pinned.length > 0 && html`<span class="chip live"><span class="dot"></span>${T.compare.live}</span>`}
    ${pins.map((pin) => html`<span class=${`chip pin-${pin.label}`} key=${pin.label}><span class="dot"></span>
      <button type="button" onClick=${() => store.take(pin.kind, pin.case)} title=${T.compare.recall(pin.label)} aria-label=${T.compare.recall(pin.label)}>${pin.label}${pin.kind !== store.state.kind ? ` (${T.kinds[pin.kind] ?? pin.kind})` : ""}</button>
      <button type="button" onClick=${() => store.unpin(pin.label)} aria-label=${T.compare.unpin(pin.label)}>✕</button></span>`)}
  </div>
  <button type="button" class="tables" aria-pressed=${tables} onClick=${() => store.set({ tables: !tables })}>${tables ? T.header.hideTables : T.header.tables}</button></div>`;
}

function leaves(thing, prefix = "") {
  const list = Array.isArray(thing) && typeof thing[0] !== "object";
  if (thing === null || typeof thing !== "object" || list) return [[prefix, thing]];
  return Object.entries(thing).flatMap(([name, inner]) => leaves(inner, prefix ? `${prefix}.${name}` : name));
}

export function Differences({ store }) {
  const { units, kind, state, pinned } = store;
  if (!pinned.length) return null;
  const { result, solved } = state;
  const paths = [...new Set([solved, ...pinned.map((pin) => pin.case)].flatMap((one) => leaves(one).map(([path]) => path)))];
  const differing = paths.filter((path) => pinned.some((pin) => !same(at(pin.case, path), at(solved, path))));
  const shown = (path, value) => {
    if (Array.isArray(value)) return value.map((one) => (Array.isArray(one) ? one.join(" ") : inputText(store, path, one))).join(", ");
    return typeof value === "number" ? inputText(store, path, value) : value === undefined ? "–" : String(value);
  };
  return html`<section class="differences" aria-label=${T.compare.title}>
    <h3>${T.compare.title}</h3>
    <div class="table-scroll" tabindex="0"><table><thead><tr><th scope="col">${T.compare.results}</th><th scope="col">${T.results.unit}</th><th scope="col">${T.compare.live}</th>
      ${pinned.map((pin) => html`<${Fragment}><th scope="col" class=${`pin-${pin.label}`}><span class="dot"></span>${pin.label}</th><th scope="col">${T.compare.live} − ${pin.label}</th><//>`)}</tr></thead>
      <tbody>${headlines(kind, result).map((output) => {
        const now = result.outputs[output.name].value;
        return html`<tr key=${output.name} data-difference=${output.name}><th scope="row"><${Symbol} of=${output.symbol} /> <${Label} of=${output.label} /></th><td>${units.text(output)}</td><td>${digits(units.shown(output, now))}</td>
          ${pinned.map((pin) => {
            const then = pin.result.outputs[output.name]?.value;
            return html`<${Fragment}><td>${digits(units.shown(output, then))}</td><td class="delta">${difference(units, output, then, now)}</td><//>`;
          })}</tr>`;
      })}</tbody>
      ${differing.length > 0 && html`<tbody><tr><th scope="rowgroup" colspan=${3 + 2 * pinned.length} class="rows">${T.compare.inputs}</th></tr>${differing.map((path) => html`<tr key=${path}><th scope="row">${path}</th><td></td>
        <td>${shown(path, at(solved, path))}</td>${pinned.map((pin) => html`<${Fragment}><td>${shown(path, at(pin.case, path))}</td><td></td><//>`)}</tr>`)}</tbody>`}
    </table></div></section>`;
}

/** A value of the case in the units that are shown, where its field is known. */
function inputText(store, path, value) {
  const field = store.fieldAt(path);
  return field?.unit && field.unit !== "holder" ? `${digits(store.units.shown(field, value))} ${store.units.text(field)}` : digits(value);
}
