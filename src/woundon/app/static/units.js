// Numbers are SI everywhere; here they become what people see, and back.
import { T } from "./texts.js";

const RAISED = { 2: "²", 3: "³", 4: "⁴", 5: "⁵" };

/** A text with its units as they are printed: "um" -> "µm", "lb/ft^3" -> "lb/ft³", "Pa*s" -> "Pa·s". */
export const typeset = (text) => text.replace(/\bum\b/g, "µm").replace(/\bdeg([CF])\b/g, "°$1").replace(/m\*\*0\.5/g, "√m")
  .replace(/(?<=[A-Za-z)])\^([2-5])(?!\d)/g, (_, power) => RAISED[power]).replace(/(?<=[A-Za-z²³])\*(?=[A-Za-z])/g, "·");

const spelled = (unit) => (unit === "deg" ? "°" : typeset(unit));

/** What a length without a field of its own is shown as, for instance a radius. */
export const LENGTH = { unit: "m", shown_unit: "mm" };

// The grammar of "66 um" and "20 lbf/in", as on the command line
const NAME = "(?:[A-Za-zµμ%°]+|[\"″])";
const TERM = `${NAME}(?:(?:\\*\\*|\\^)?-?\\d|[²³])?`;
const DIVISOR = `/\\s*\\d+(?:\\.\\d+)?\\s*${TERM}`; // N/15 mm
const UNIT = new RegExp(`^(?:1/(?:[Ks]|deg[CF])|${TERM}(?:(?:\\s*[*/·]\\s*|\\s+)${TERM}|\\s*${DIVISOR})*)$`);
const FACTOR = new RegExp(`([*/·]?)\\s*(\\d+(?:\\.\\d+)?)?\\s*(${NAME})((?:(?:\\*\\*|\\^)?-?\\d|[²³])?)`, "g");
const REAM = /^(lbs?)\s*(?:\/|per)?\s*(?:ream)?\s*\(?(\d{1,3}(?:\.\d)?)\s*[xX×]\s*(\d{1,3}(?:\.\d)?)(?:\s*in)?(?:\s*[/-]\s*(\d{3}))?\)?$/;
// masses that are read as forces: lb/in is lbf/in; kg and g are forces per width only
const FORCES = { lb: "lbf", lbs: "lbf", oz: "ozf" };
const LINE_FORCES = { ...FORCES, kg: "kgf", g: "gf" };
const QUANTITY = /^([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d{1,3})?)\s*(.*)$/i;
const GROUPED = /^[+-]?\d+[,' _]\d/; // 1,000 and 3,5
// Messages: the number that they begin with, and numbers that are neither a factor or divisor
// ("0.5 * radius") nor a part of a name ("E0")
const LEADING = /^(-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?= )|)(.*)$/s;
const NUMBERS = /(?<![*/]\s*)(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.]*\s*[*/])(?!\w)/g;
// Texts of results: numbers before their common unit, "23.4 mm", "2 and 3 GPa"
const PLAIN = /[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?/g;
const WITH_UNIT = new RegExp(`(?<![\\w.])(${PLAIN.source}(?:(?:, | to | and )${PLAIN.source})*) ([A-Za-z][\\w/^*]*)(?![\\w/^*])`, "g");
const USUAL = { m: "mm", Pa: "kPa", rad: "deg" };

/** A quantity of an SI unit that no field has, e.g. a radius in a message. */
export const usual = (unit) => ({ unit, shown_unit: USUAL[unit] ?? unit });

/** How quantities are shown in a system of units ("SI", "mill") of the catalogue. */
export class Units {
  constructor(catalogue, system) {
    this.units = catalogue.units;
    this.definitions = catalogue.unit_definitions;
    this.system = catalogue.systems[system] ?? {};
    this.name = system;
  }

  /** The unit of a quantity {unit, shown_unit}: its name and how many SI units it is. */
  of(quantity) {
    const shown = quantity.shown_unit || quantity.unit || "1";
    const wanted = this.system[shown] ?? shown;
    const known = this.units[quantity.unit] ?? [];
    const name = (unit) => (unit === "1" ? "" : unit);
    return known.find((unit) => unit.name === name(wanted))
      ?? known.find((unit) => unit.name === name(shown)) ?? { name: name(quantity.unit), factor: 1 };
  }

  shown(quantity, value) {
    return value == null ? null : value / this.of(quantity).factor;
  }

  si(quantity, shown) {
    // as the command line reads "66 um": to the last digit that was written
    return Number((shown * this.of(quantity).factor).toPrecision(15));
  }

  text(quantity) {
    return spelled(this.of(quantity).name);
  }

  /**
   * Read a number in the shown unit, or with a unit of its own: {value} in SI, or {fault}.
   * `web` holds width, thickness and density, with which totals, stresses and basis weights are
   * converted; "ø 6 in" is a diameter.
   */
  read(quantity, text, range, web = {}) {
    const typed = text.trim().replace("−", "-");
    const diameter = /^[øØ⌀]\s*(.*)$/.exec(typed);
    if (diameter && quantity.unit === "m") {
      const { value, fault } = this.read(quantity, diameter[1], range);
      return fault ? { fault } : { value: value / 2 };
    }
    if (GROUPED.test(typed)) return { fault: T.form.separators(text) };
    const [, number, unit] = QUANTITY.exec(typed) ?? [];
    if (number === undefined || !Number.isFinite(Number(number))) return { fault: T.form.notNumber(text, range) };
    if (!unit) return { value: this.si(quantity, Number(number)) };
    const given = this.product(unit);
    if (!given) return { fault: T.form.unknownUnit(unit, this.text(quantity)) };
    for (const [from, needed, factor] of formsOf(quantity, web)) {
      const due = this.product(from);
      const readings = [given, this.product(unit, from === "N/m" ? LINE_FORCES : FORCES)];
      const fitting = due && readings.find((reading) => same(reading.powers, due.powers));
      if (!fitting) continue;
      if (!(factor > 0)) return { fault: T.form.needed(unit, needed) };
      return { value: Number((Number(number) * fitting.factor / due.factor * factor).toPrecision(15)) };
    }
    return { fault: T.form.wrongDimension(unit, this.text(quantity)) };
  }

  /** The factor to SI base units and their powers of a unit such as "lbf/in"; null if unknown. */
  product(text, forces = {}) {
    if (text === "1") return { factor: 1, powers: {} };
    const unit = text.replace(REAM, (_, pound, a, b, sheets) => `${pound}/${a * b * (sheets ?? 500)} in^2`);
    if (!UNIT.test(unit)) return null;
    const result = { factor: 1, powers: {} };
    for (const [, sign, divisor, name, raised] of unit.matchAll(FACTOR)) {
      if (!Object.hasOwn(this.definitions, name)) return null;
      const known = this.definitions[forces[name] ?? name];
      const power = Number(raised.replace("²", "2").replace("³", "3").replace(/[*^]/g, "") || 1) * (sign === "/" ? -1 : 1);
      result.factor *= known.factor ** power / Number(divisor ?? 1);
      for (const [base, times] of Object.entries(known.powers)) result.powers[base] = (result.powers[base] ?? 0) + times * power;
    }
    return result;
  }

  /**
   * A message of the server in the shown units: its SI numbers stand before their unit, "0.5 [m]".
   * What it quotes stays as it was written.
   */
  message(text, quantity = null) {
    return this.converted(text, quantity).replace(/'[^']*'|[^']+/g, (part) => (part.startsWith("'") ? part : typeset(part)));
  }

  converted(text, quantity) {
    const [, first, rest] = LEADING.exec(text.replace(/ \(plain numbers are SI:[^)]*\)/, ""));
    const as = (unit) => (quantity?.unit === unit ? quantity : usual(unit));
    const shown = (value, of) => digits(this.shown(of, Number(value)), 6);
    const pure = quantity?.unit === "1" ? ` ${this.text(quantity)}`.trimEnd() : ""; // "%", without brackets
    const start = first && quantity && this.units[quantity.unit] ? shown(first, quantity) + pure : first;
    if (pure && !rest.includes("[")) return start + rest.replace(NUMBERS, (value) => shown(value, quantity) + pure);
    return start + rest.replace(/([^[\]]*)\[([^[\]]+)\]/g, (part, words, unit) => (this.units[unit]
      ? `${words.replace(NUMBERS, (value) => shown(value, as(unit)))}[${this.text(as(unit))}]` : part));
  }

  /** A text of a result, such as a warning, in the shown units; the server writes it in the usual ones. */
  sentence(text) {
    return typeset(text.replace(WITH_UNIT, (part, numbers, usualUnit) => {
      const unit = this.system[usualUnit];
      if (!unit) return part;
      const ratio = this.product(usualUnit).factor / this.product(unit).factor;
      const count = (number) => Math.max(3, number.replace(/e.*|\D/g, "").replace(/^0+/, "").length);
      return `${numbers.replace(PLAIN, (number) => digits(Number(number) * ratio, count(number)))} ${spelled(unit)}`;
    }));
  }

  /** "words [unit]" */
  label(words, quantity) {
    const unit = this.text(quantity);
    return unit ? `${words} [${unit}]` : words;
  }
}

/** The units that a quantity may be entered in: [SI unit, what it is converted with, factor]. */
function formsOf({ unit, other_form: other }, { width, thickness, density }) {
  const forms = [[unit, "", 1]];
  if (unit === "N/m") forms.push(["N", "width", 1 / width]);
  if (other === "stress") forms.push(["Pa", "thickness", thickness]);
  if (other === "basis weight" && unit === "m") forms.push(["kg/m^2", "density", 1 / density]);
  if (other === "basis weight" && unit !== "m") forms.push(["kg/m^2", "thickness", 1 / thickness]);
  return forms;
}

/** Whether two products of base units have the same dimension. */
function same(a, b) {
  return [...new Set([...Object.keys(a), ...Object.keys(b)])].every((base) => (a[base] ?? 0) === (b[base] ?? 0));
}

/** A number in so many significant digits, without needless zeros. */
export function digits(value, count = 5) {
  if (value == null || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = value.toPrecision(count);
  if (size >= 1e7 || size < 1e-4) {
    const [mantissa, power] = Number(text).toExponential().split("e");
    return `${mantissa.replace("-", "−")}e${power.replace("+", "")}`;
  }
  return String(Number(text)).replace("-", "−");
}

/** Round numbers within an interval, about `count` of them. */
export function niceTicks(low, high, count = 5) {
  const least = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((n) => n * power).find((one) => one >= least * (1 - 1e-9));
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high * (1 + 1e-9); k++) ticks.push(Number((k * step).toPrecision(12)));
  return ticks;
}

/** The number that a text means; NaN for none. */
export function parsed(text) {
  const plain = text.trim().replace("−", "-");
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
}
