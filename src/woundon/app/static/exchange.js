// In and out: case files, data, pictures, a link to the state, Python, the report.
import { writeAddress } from "./address.js";
import * as api from "./api.js";
import { linesOf, tablesOf } from "./chart.js";
import { html, useEffect, useRef, useState } from "./html.js";
import { wordsText } from "./symbols.js";
import { T } from "./texts.js";
import { digits } from "./units.js";

const MOST = 1_000_000; // bytes of a case file

/** Let the browser save a file. */
export function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

// ---- files ----

async function open(store, file) {
  if (!file) return;
  if (file.size > MOST) return store.showErrors({ errors: [], message: T.menu.tooBig(`${digits(file.size / 1e6, 3)} MB`) });
  let toml;
  try {
    toml = new TextDecoder("utf-8", { fatal: true }).decode(await file.arrayBuffer());
  } catch {
    return store.showErrors({ errors: [], message: T.menu.notText });
  }
  try {
    const { kind, problem } = await api.readCase(toml);
    store.set({ tab: kind === "roll" || kind === "winding" ? "winding" : "case" });
    store.take(kind, problem);
    store.say(T.menu.opened(file.name));
  } catch (fault) {
    store.showErrors({ errors: [], message: store.textOf(fault) });
  }
}

/** The states that are seen, for pictures and reports. */
function seen(store) {
  const { solved } = store.state;
  const pins = store.pinned.map((pin) => ({ label: pin.label, case: pin.case }));
  const live = { label: pins.length ? T.compare.live : T.kinds[store.state.kind] ?? store.state.kind, case: solved };
  return pins.length >= store.catalogue.limits.compare ? pins : [live, ...pins];
}

/** The system of units that is shown, as the server takes it. */
const unitsOf = ({ units }) => (units.name === "SI" ? undefined : units.name);

/** A column of a CSV file in the shown units: its heading and its values [SI]. */
export function csvColumn(units, words, quantity, values) {
  return { head: units.label(words, quantity), values: values.map((value) => units.shown(quantity, value)) };
}

/** The text of a CSV file with these columns. */
/** Decimal commas and semicolons in CSV files, for spreadsheets that expect them. */
export const csvStyle = { commas: false };

export function csvOf(columns) {
  const separator = csvStyle.commas ? ";" : ",";
  const number = (value) => (csvStyle.commas ? String(value).replace(".", ",") : value);
  const quote = (text) => {
    const cell = /^'*[=+@\t\r-]/.test(text) ? `'${text}` : text; // a spreadsheet would take it for a formula
    return cell.includes(separator) || /["\r\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell;
  };
  const heads = columns.map(({ head }) => quote(head)).join(separator);
  const rows = columns[0].values.map((_, k) => columns.map(({ values }) => (values[k] == null ? "" : number(Number(values[k].toPrecision(9))))).join(separator));
  return `${[heads, ...rows].join("\n")}\n`;
}

/** What the panels show as CSV: a table for every x. */
function csvOfPanels({ units, state, pinned }) {
  const states = [{ label: "", result: state.result }, ...pinned];
  return states.flatMap(({ label, result }) => result.panels.flatMap((panel) => tablesOf(linesOf([{ label, panel }])).map(({ x, axis, columns }) => csvOf([
    csvColumn(units, axis.label, axis.quantity, x),
    ...columns.map(({ curve, axis: own }) => csvColumn(units, `${label} ${curve.name} ${wordsText(curve.label)}`.trim(), own.quantity, curve.y)),
  ])))).join("\n");
}

// ---- the menu ----

export function Menu({ store }) {
  const [dialog, setDialog] = useState(null);
  const details = useRef(null);
  const input = useRef(null);
  const tables = store.state.solved;
  const guarded = (work) => async () => {
    details.current.open = false;
    try {
      await work();
    } catch (fault) {
      store.showErrors({ errors: [], message: fault.message });
    }
  };
  const name = (ending) => `${store.state.kind}.${ending}`;
  const picture = (format) => async () => save(await api.figure(format, { cases: seen(store), units: unitsOf(store) }), name(format));
  const acts = [
    [T.menu.open, () => input.current.click()],
    [T.menu.save, async () => save(new Blob([await api.writeCase(store.state.case)], { type: "application/toml" }), name("toml"))],
    [T.menu.csv, () => save(new Blob([csvOfPanels(store)], { type: "text/csv" }), name("csv"))],
    [T.menu.png, picture("png")],
    [T.menu.svg, picture("svg")],
    [T.menu.link, async () => {
      await writeAddress(store);
      await navigator.clipboard?.writeText(location.href).then(() => store.say(T.menu.copied), () => setDialog({ title: T.menu.link, text: location.href }));
    }],
    [T.menu.python, async () => setDialog({ title: T.menu.python, text: await api.python(tables) })],
    [T.menu.report, () => setDialog({ title: T.menu.report.replace(" …", ""), report: true })],
  ];
  useEffect(() => {
    const away = (event) => { if (details.current && !details.current.contains(event.target)) details.current.open = false; };
    document.addEventListener("click", away);
    return () => document.removeEventListener("click", away);
  }, []);
  useEffect(() => {
    const over = (event) => event.preventDefault();
    const drop = (event) => { event.preventDefault(); open(store, event.dataTransfer?.files?.[0]); };
    addEventListener("dragover", over);
    addEventListener("drop", drop);
    return () => { removeEventListener("dragover", over); removeEventListener("drop", drop); };
  }, [store]);
  const leave = (event) => { if (event.key === "Escape") { details.current.open = false; details.current.querySelector("summary").focus(); } };
  return html`<details class="menu" ref=${details} onKeyDown=${leave}><summary>${T.header.menu}</summary>
      <div class="menu-list">${acts.map(([label, act]) => html`<button type="button" key=${label} onClick=${guarded(act)}>${label}</button>`)}
        <label><input type="checkbox" id="csv-commas" checked=${csvStyle.commas} onChange=${(event) => { csvStyle.commas = event.target.checked; }} /> ${T.menu.commas}</label>
        <a href="/api" target="_blank" rel="noopener">${T.menu.api}</a>
        <label class="theme">${T.header.theme}<select value=${store.state.theme} onChange=${(event) => store.prefer("theme", event.target.value)}>
          ${[["", T.header.auto], ["light", T.header.light], ["dark", T.header.dark]].map(([value, word]) => html`<option value=${value} selected=${value === store.state.theme}>${word}</option>`)}</select></label></div>
    </details>
    <input type="file" class="hidden" ref=${input} accept=".toml,text/plain,application/toml" aria-label=${T.menu.open} tabindex="-1"
      onChange=${(event) => { open(store, event.target.files[0]); event.target.value = ""; }} />
    ${dialog && html`<${Dialog} title=${dialog.title} close=${() => setDialog(null)}>
      ${dialog.report ? html`<${Report} store=${store} close=${() => setDialog(null)} />` : html`<${Snippet} text=${dialog.text} store=${store} />`}<//>`}`;
}

export function Dialog({ title, close, children }) {
  const box = useRef(null);
  useEffect(() => { box.current.showModal(); }, []);
  return html`<dialog ref=${box} onClose=${close} aria-label=${title} onClick=${(event) => { if (event.target === box.current) box.current.close(); }}>
    <div class="dialog-head"><h2>${title}</h2><button type="button" onClick=${() => box.current.close()} aria-label=${T.menu.close}>✕</button></div>
    ${children}</dialog>`;
}

function Snippet({ text, store }) {
  const copy = async () => { await navigator.clipboard.writeText(text); store.say(T.menu.copied); };
  return html`<pre class="snippet" tabindex="0">${text}</pre><div class="dialog-foot"><button type="button" class="primary" onClick=${copy}>${T.menu.copy}</button></div>`;
}

function Report({ store, close }) {
  const [title, setTitle] = useState("");
  const [remarks, setRemarks] = useState("");
  const [state, setState] = useState({});
  const make = async () => {
    setState({ busy: true });
    try {
      const blob = await api.report({ cases: seen(store), units: unitsOf(store), title: title || undefined, remarks: remarks || undefined });
      save(blob, `${store.state.kind}.html`);
      close();
    } catch (fault) {
      setState({ fault: fault.message });
    }
  };
  return html`<p>${T.menu.reportAbout}</p>
    <label class="stacked">${T.menu.heading}<input type="text" value=${title} maxlength="200" onInput=${(event) => setTitle(event.target.value)} /></label>
    <label class="stacked">${T.menu.remarks}<textarea rows="4" maxlength="5000" onInput=${(event) => setRemarks(event.target.value)}>${remarks}</textarea></label>
    ${state.fault && html`<p class="fault" role="alert">${state.fault}</p>`}
    <div class="dialog-foot"><button type="button" class="primary" disabled=${state.busy} onClick=${make}>${T.menu.make}</button></div>`;
}
