// Symbols of the formulas ("mu+", "s_l+", "2a") as markup, and as text for canvases.
import { html } from "./html.js";

const GREEK = {
  alpha: "α", beta: "β", delta: "δ", Delta: "Δ", eps: "ε", gamma: "γ", kappa: "κ", mu: "μ", nu: "ν",
  rho: "ρ", sigma: "σ", tau: "τ", theta: "θ", xi: "ξ", omega: "ω",
};
const FORM = /^(\d*)([A-Za-z]+?)(\d*)(?:_(\w+(?:,\w+)*))?\^?([+-]?|(?<=\^)\d)$/;

function parts(symbol) {
  const found = FORM.exec(symbol);
  if (!found) return null;
  const [, factor, base, number, index, sign] = found;
  return { factor, base: GREEK[base] ?? base, below: number + (GREEK[index] ?? index ?? ""), sign };
}

/** The symbol as markup: words ("mu+ p") and quotients ("mu/mu0") of symbols. */
export function Symbol({ of }) {
  return of.split(/([ /])/).map((word, k) => {
    if (k % 2) return word;
    const p = parts(word);
    if (!p) return html`<i>${word}</i>`;
    return html`<i>${p.factor}${p.base}</i>${p.below && html`<sub>${p.below}</sub>`}${
      p.sign && html`<sup>${p.sign === "-" ? "−" : p.sign}</sup>`}`;
  });
}

/** A word of a label that is a symbol, or a quotient of symbols: "T_in", "-M2/R2", "WOT". */
function isSymbol(word) {
  return word.replace(/^-/, "").split("/").every((one) => {
    const p = parts(one);
    return p && (p.below || p.sign || one in GREEK || /^([A-Z]|WOT|NIT)$/.test(one));
  });
}

const OPERATORS = { "=": "=", "-": "−", "+": "+" };

/** A label whose formula is typeset: "nip-induced tension, WOT - T_in"; a formula is not broken. */
export function Label({ of }) {
  let inFormula = false;
  return of.split(" ").map((word, k) => {
    const [, text, end] = /^(.*?)([,;:]?)$/.exec(word);
    const symbol = isSymbol(text);
    const joined = inFormula && (symbol || text in OPERATORS);
    inFormula = symbol || (inFormula && text in OPERATORS);
    const space = k ? (joined ? "\u00a0" : " ") : "";
    if (!symbol) return `${space}${joined ? OPERATORS[text] : text}${end}`;
    return html`${space}${text.startsWith("-") ? "−" : ""}<${Symbol} of=${text.replace(/^-/, "")} />${end}`;
  });
}

const RAISED = { "+": "⁺", "-": "⁻", 2: "²", 3: "³" };

/** The symbol as plain text. */
export function symbolText(symbol) {
  return symbol.split(/([ /])/).map((word) => {
    const p = parts(word);
    return p ? p.factor + p.base + (p.below ? `_${p.below}` : "") + (RAISED[p.sign] ?? "") : word;
  }).join("");
}

const FORMULA = /\$([^$]*)\$/;
const WORD = /([A-Za-z]+\d*(?:_\w+)?[+-]?)/;

/** A label with formulas between dollars: "$|q+|/mu+$", "on roll". */
export function Words({ of }) {
  return of.split(FORMULA).map((part, k) => (k % 2 ? part.split(WORD).map((word, n) => (n % 2 ? html`<${Symbol} of=${word} />` : word)) : part));
}

/** The label as plain text. */
export function wordsText(of) {
  return of.split(FORMULA).map((part, k) => (k % 2 ? part.split(WORD).map((word, n) => (n % 2 ? symbolText(word) : word)).join("") : part)).join("");
}
