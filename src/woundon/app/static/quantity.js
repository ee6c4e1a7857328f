// Text boxes of quantities: the value is in SI, the text in the unit that the page shows.
import { same } from "./cases.js";
import { html, useState } from "./html.js";
import { T } from "./texts.js";

/** The text of a value in SI, in the unit that is shown. */
export function plain(units, quantity, value) {
  if (!Number.isFinite(value)) return "";
  const number = Number(units.shown(quantity, value).toPrecision(6));
  return number && Math.abs(number) < 1e-3 ? number.toExponential() : String(number);
}

/**
 * The text that is typed into a box, as long as its value holds and the page keeps its units:
 * [text or null, keep(text, value), forget()].
 */
export function useTyped(units, value) {
  const [typed, setTyped] = useState(null);
  const holds = typed?.units === units && same(typed.value, value);
  return [holds ? typed.text : null, (text, next) => setTyped({ text, units, value: next }), () => setTyped(null)];
}

/** Read a text in the shown unit, or with a unit of its own: {value} in SI, or {fault}. */
export function readQuantity({ units, state }, quantity, text, range = T.form.finite) {
  const { width, density, web, web_thickness } = state.case;
  return units.read(quantity, text, range, { width, density, thickness: web?.thickness ?? web_thickness });
}

/**
 * A box for the value [SI] of a quantity. `put(value, fault)` takes the value of each text that is
 * typed, undefined for an empty one, or its fault; it returns the value that is then shown.
 */
export function QuantityBox({ store, quantity, value, put, read = (text) => readQuantity(store, quantity, text), optional = false, wrong, onLeave = () => {}, ...attributes }) {
  const { units } = store;
  const [typed, keep, forget] = useTyped(units, value);
  const parse = (text) => (optional && !text.trim() ? {} : read(text));
  const fault = typed == null ? undefined : parse(typed).fault;
  const take = (text) => { const { value: si, fault: found } = parse(text); keep(text, put(si, found)); };
  const leave = () => { if (!fault) forget(); onLeave(); };
  return html`<input type="text" inputmode="decimal" autocomplete="off" spellcheck=${false} title=${fault} ...${attributes}
    value=${typed ?? plain(units, quantity, value)} aria-invalid=${fault || wrong ? "true" : "false"}
    onInput=${(event) => take(event.target.value)} onBlur=${leave}
    onKeyDown=${(event) => { if (event.key === "Escape") { forget(); put(value); } }} />`;
}
