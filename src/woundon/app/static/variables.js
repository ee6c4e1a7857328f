// The numbers of a case that can be varied or found, with their fields; the outputs of its result.
import { T } from "./texts.js";

export function variables(store) {
  const found = [];
  const walk = (tables, prefix) => {
    for (const [name, value] of Object.entries(tables)) {
      const path = prefix ? `${prefix}.${name}` : name;
      if (value && typeof value === "object" && !Array.isArray(value)) walk(value, path);
      else if (Array.isArray(value) && value[0] && typeof value[0] === "object") value.forEach((item, k) => walk(item, `${path}.${k}`));
      else if (typeof value === "number") {
        const field = store.fieldAt(path);
        if (field?.typical || field?.limits) found.push({ path, field, value });
      }
    }
  };
  walk(store.state.case, "");
  return found;
}

/** The variable that was changed last, else the load, else the first one. */
export function defaultVariable(store, known) {
  const named = (path) => known.find((one) => one.path === path);
  return named(store.changedPath) ?? named(store.loadOf(store.kind)) ?? known[0];
}

/** The scalar outputs that the present result has, the main one of the kind first. */
export function outputsOf({ kind, state: { result } }) {
  const known = result?.kind === kind.name ? result.outputs : {}; // as losses of elastic bodies are not
  const scalars = kind.outputs.filter((output) => !output.array && !output.whole && known[output.name]?.value != null);
  return [...scalars.filter((one) => kind.main.includes(one.name)), ...scalars.filter((one) => !kind.main.includes(one.name))];
}

/** Options of a selection of variables: labels, with the table for labels that occur twice. */
export function labelOf({ path, field }) {
  const tables = path.split(".").slice(0, -1).join(" ");
  return tables ? `${field.label} (${tables.replaceAll("_", " ")})` : field.label;
}

/** The outputs on cards: the kind's own, and those with an estimated error. */
export function headlines(kind, result) {
  const { outputs } = result;
  // without a core there is no pressure on it
  const without = result.problem?.core_removed ? ["core_pressure", "worst_lane.core_pressure"] : [];
  const scalars = kind.outputs.filter((output) => !output.array && outputs[output.name]?.value != null && !without.includes(output.name));
  const named = (names) => names.map((name) => scalars.find((output) => output.name === name)).filter(Boolean);
  const main = named(kind.main);
  const usual = named(T.order);
  if (usual.length >= 3) return [...new Set([...main, ...usual])];
  const estimated = scalars.filter((output) => outputs[output.name].error != null && !main.includes(output));
  const rest = scalars.filter((output) => !main.includes(output) && !estimated.includes(output) && !output.whole);
  return [...main, ...estimated, ...(main.length + estimated.length > 2 ? [] : rest.slice(0, 7))];
}

/** The names of the outputs that are drawn around the working point: the tensions, or the first output on a card. */
export function curveOutputs(kind, result) {
  const names = headlines(kind, result).map(({ name }) => name);
  const tensions = names.filter((name) => name.endsWith("tension"));
  return tensions.length ? tensions : names.slice(0, 1);
}
