// Numbers are SI everywhere; here they become what people see, and back.

const SPELT = { um: "µm", deg: "°", "kg/m^3": "kg/m³", "kg/m^2": "kg/m²", "m/s^2": "m/s²" };

/** How quantities are shown in a system of units ("SI", "mill") of the catalogue. */
export class Units {
  constructor(catalogue, system) {
    this.units = catalogue.units;
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
    const { name } = this.of(quantity);
    return SPELT[name] ?? name;
  }

  /** "words [unit]" */
  label(words, quantity) {
    const unit = this.text(quantity);
    return unit ? `${words} [${unit}]` : words;
  }
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

/** The number that a text means; NaN for none. */
export function parsed(text) {
  const plain = text.trim().replace("−", "-");
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
}
