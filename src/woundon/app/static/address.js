// The state of the page in its address: the fragment, which stays in the browser, holds the case;
// tabs are entries of the history.
import * as api from "./api.js";
import { at } from "./cases.js";
import { TABS } from "./store.js";
import { T } from "./texts.js";

const LONGEST = 30_000; // characters of a fragment
const MOST = 1_000_000; // characters of what it says
const REST = 300; // [ms] without a change, after which the address follows; browsers limit how often

// ---- text of a state: JSON, compressed with its checksum (zlib) ----

async function encode(state) {
  const packed = new Blob([JSON.stringify(state)]).stream().pipeThrough(new CompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(packed).arrayBuffer());
  const code = btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  return code.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** Undo `encode`; a text that is damaged, or too long, is an error. */
async function decode(code) {
  if (code.length > LONGEST) throw new Error("too long");
  const bytes = Uint8Array.from(atob(code.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")).pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return JSON.parse(text);
    text += value;
    if (text.length > MOST) throw new Error("too long");
  }
}

// ---- to the address ----

function stateOf(store) {
  const { kind, case: tables, system, tab, pins, others } = store.state;
  return { kind, case: tables, system, tab, others, pins: pins.map((pin) => ({ label: pin.label, kind: pin.kind, case: pin.case })) };
}

/** Write the state into the address. */
export async function writeAddress(store) {
  const { tab, pins, past } = store.state;
  const isFirst = tab === "case" && !past.length && !pins.length; // the example of a new page
  const code = isFirst ? "" : await encode(stateOf(store));
  if (code.length > LONGEST) store.say(T.address.long);
  history.replaceState({ tab: store.state.tab }, "", code && code.length <= LONGEST ? `#${code}` : location.pathname + location.search);
}

// ---- a page that is left before the address has followed: encoding does not end before it is left ----

const UNSAVED = "woundon.unsaved"; // of this tab

function keepUnsaved(store) {
  try {
    sessionStorage.setItem(UNSAVED, JSON.stringify({ hash: location.hash, state: stateOf(store) }));
  } catch { /* private windows */ }
}

/** Return the state with which this page was left by a reload, if the address does not hold it; it is kept no longer. */
function takeUnsaved() {
  try {
    const { hash, state } = JSON.parse(sessionStorage.getItem(UNSAVED) ?? "{}");
    sessionStorage.removeItem(UNSAVED);
    const [navigation] = performance.getEntriesByType("navigation");
    return navigation?.type === "reload" && hash === location.hash ? state : undefined;
  } catch {
    return undefined;
  }
}

/** Let the address follow the state, and the state follow back and forward. */
export function keepAddress(store) {
  let { tab } = store.state;
  let timer = 0;
  let unsaved = 0; // changes that the address does not hold
  let before = null;
  const save = async () => {
    clearTimeout(timer);
    const count = unsaved;
    await writeAddress(store);
    unsaved -= count;
  };
  history.replaceState({ tab }, "");
  store.listeners.add(() => {
    const { state } = store;
    const now = [state.kind, state.case, state.system, state.tab, state.pins, state.others];
    if (before?.every((part, k) => part === now[k])) return;
    before = now;
    if (state.tab !== tab) history.pushState({ tab: state.tab }, "");
    tab = state.tab;
    clearTimeout(timer);
    unsaved += 1;
    timer = setTimeout(save, REST);
  });
  addEventListener("visibilitychange", () => { if (document.hidden && unsaved) save(); });
  addEventListener("pagehide", () => { if (unsaved) keepUnsaved(store); });
  addEventListener("pageshow", ({ persisted }) => { if (persisted) takeUnsaved(); }); // this page has it
  addEventListener("popstate", async ({ state }) => {
    if (TABS.includes(state?.tab)) {
      tab = state.tab; // it is an entry already
      store.show(tab);
    } else { // a link was entered
      const code = location.hash;
      await restore(store, () => { tab = store.state.tab; });
      if (code === location.hash) history.replaceState({ tab }, "");
    }
  });
}

// ---- from the address ----

const isPlain = (thing) => thing !== null && typeof thing === "object" && !Array.isArray(thing);

/** Whether something is a case of a kind, or would be one with other numbers in its fields; the server says. */
async function isCase(store, kind, tables) {
  if (!store.kindOf(kind) || !isPlain(tables)) return false;
  try {
    return (await api.readCase(await api.writeCase(tables))).kind === kind;
  } catch ({ errors }) {
    return errors?.length > 0 && errors.every(({ field }) => {
      if (!field) return true; // of several fields together
      const known = store.fieldOf(kind, tables, field) ?? store.fieldOf(kind, tables, field.replace(/\.\d+$/, ""));
      return (["number", "numbers"].includes(known?.type) || known?.number) && ["number", "undefined"].includes(typeof at(tables, field));
    });
  }
}

/** Restore what the address holds, and return true; a damaged one is rejected as a whole. */
export async function restore(store, beforeShown = () => {}) {
  const code = location.hash.slice(1);
  const unsaved = takeUnsaved();
  if (!code && !unsaved) return false;
  try {
    const state = unsaved ?? await decode(code);
    if (!await isCase(store, state.kind, state.case)) throw new Error("no case");
    const others = {};
    for (const [kind, tables] of Object.entries(state.others ?? {})) if (await isCase(store, kind, tables)) others[kind] = tables;
    const solved = []; // one after the other: of several at once the newest wins
    for (const pin of (Array.isArray(state.pins) ? state.pins : []).slice(0, 4)) {
      const result = store.kindOf(pin?.kind) && /^[A-D]$/.test(pin.label) && await api.solve(pin.case, {}).catch(() => null);
      if (result?.kind === pin?.kind) solved.push({ label: pin.label, kind: pin.kind, case: pin.case, result, extras: {} });
    }
    if (store.catalogue.systems[state.system]) store.set({ system: state.system });
    store.set({ pins: solved, others, tab: TABS.includes(state.tab) ? state.tab : "case" });
    beforeShown();
    store.take(state.kind, state.case);
    return true;
  } catch {
    store.set({ notice: T.address.broken });
    return false;
  }
}
