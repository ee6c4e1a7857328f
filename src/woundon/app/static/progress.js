// Studies that the server computes while other tabs are shown: sweeps, fits, operating windows.
import { html } from "./html.js";
import { T } from "./texts.js";

/**
 * Run a study, whose outcome is the part `name` of the store's state.
 *
 * `request(handle, signal)` streams its events; `take(event, outcome)` returns what an event adds to the outcome.
 */
export async function runStudy(store, name, request, take) {
  const abort = new AbortController();
  const outcome = { kind: store.state.kind, done: 0, of: 0, running: true, text: "", abort };
  const put = (patch) => { Object.assign(outcome, patch); store.set({ [name]: { ...outcome } }); };
  put({});
  try {
    await request((event) => {
      if (event.event === "cancelled") put({ text: T.study.cancelled });
      else if (event.event === "progress") put({ done: event.done, of: event.of });
      else put(take(event, outcome));
    }, abort.signal);
    put({ running: false });
  } catch (fault) {
    put({ running: false, ...(fault.name === "AbortError" ? { text: T.study.cancelled } : { fault }) });
  }
}

/** The buttons that start a study and cancel it. */
export function RunButtons({ name, study, words, ready, run, children }) {
  return html`<div class="study-run"><button type="button" class="primary" id=${`${name}-run`} disabled=${!ready || study?.running} onClick=${run}>${words}</button>
    <button type="button" id=${`${name}-cancel`} disabled=${!study?.running} onClick=${() => study.abort.abort()}>${T.study.cancel}</button>${children}</div>`;
}

/** Progress and errors of a study; `words` are those of its progress. */
export function StudyState({ store, study, words, children }) {
  return study && html`<div class="study-state" role="status"><progress max=${study.of || 1} value=${study.done} aria-label=${words}></progress>
    <span>${words}</span> <b>${study.text}</b>${children}
    ${study.fault && html`<span class="fault" role="alert">${store.textOf(study.fault)}</span>`}</div>`;
}
