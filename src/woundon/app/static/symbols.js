// Symbols of the formulas ("mu+", "s_l+", "2a") as markup, and as text for canvases.
import { html } from "./html.js";

const GREEK = {
  alpha: "α", beta: "β", delta: "δ", Delta: "Δ", eps: "ε", gamma: "γ", kappa: "κ", mu: "μ", nu: "ν",
  rho: "ρ", sigma: "σ", tau: "τ", theta: "θ", xi: "ξ", omega: "ω",
};
const FORM = /^(\d*)([A-Za-z]+?)(\d*)(?:_(\w+))?([+-]?)$/;

function parts(symbol) {
  const found = FORM.exec(symbol);
  if (!found) return null;
  const [, factor, base, number, index, sign] = found;
  return { factor, base: GREEK[base] ?? base, below: number + (index ?? ""), sign };
}

/** The symbol as markup, words apart ("mu+ p"). */
export function Symbol({ of }) {
  return of.split(" ").map((word, k) => {
    const p = parts(word);
    const space = k ? " " : "";
    if (!p) return html`${space}<i>${word}</i>`;
    return html`${space}<i>${p.factor}${p.base}</i>${p.below && html`<sub>${p.below}</sub>`}${
      p.sign && html`<sup>${p.sign === "-" ? "−" : "+"}</sup>`}`;
  });
}

const RAISED = { "+": "⁺", "-": "⁻" };

/** The symbol as plain text. */
export function symbolText(symbol) {
  return symbol.split(" ").map((word) => {
    const p = parts(word);
    return p ? p.factor + p.base + (p.below ? `_${p.below}` : "") + (RAISED[p.sign] ?? "") : word;
  }).join(" ");
}
