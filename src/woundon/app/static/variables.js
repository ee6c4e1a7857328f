// The numbers of a case that can be varied or found, with their fields.

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
