// A case is a nested plain object, the tables of a case file; paths are dotted, items by number.

export function at(thing, path) {
  return path.split(".").reduce((inner, name) => (inner == null ? undefined : inner[name]), thing);
}

/** A copy with one place changed; undefined takes it away. */
export function changed(thing, path, value) {
  const [name, ...rest] = path.split(".");
  const copy = Array.isArray(thing) ? [...thing] : { ...thing };
  const inner = rest.length ? changed(copy[name] ?? {}, rest.join("."), value) : value;
  if (inner === undefined) delete copy[name];
  else copy[name] = inner;
  return copy;
}

export const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** The member of an open set that a table describes: by its kind, else by the names of its fields. */
export function memberOf(catalogue, field, value) {
  if (typeof value === "string" || typeof value === "number" || value == null) return null;
  const byKind = field.members.find((member) => member.kind !== null && member.kind === value.kind);
  if (byKind) return byKind;
  const names = Object.keys(value).filter((name) => name !== "kind");
  const knows = (member) => {
    const known = fieldsOf(catalogue, member.form).map((inner) => inner.name);
    return names.filter((name) => known.includes(name)).length;
  };
  return [...field.members].sort((a, b) => knows(b) - knows(a))[0] ?? null;
}

export const fieldsOf = (catalogue, form) => catalogue.forms[form]?.fields ?? [];

/** A field of a schedule has the unit of the field that holds the schedule. */
export function held(field, holder) {
  if (field.unit !== "holder" || !holder) return field;
  const { symbol, unit, shown_unit, typical, limits, other_form } = holder;
  return { ...field, symbol, unit, shown_unit, typical, limits, other_form };
}

/** The values of a nip with which a roll or a winding starts, by path; the roll is wound to that of the nip. */
export function ofNip(catalogue, kind, nip, tension) {
  const { web, roll } = nip;
  const material = (described) => (typeof described === "string" ? catalogue.materials.find(({ name }) => name === described)?.material : described);
  const { tangential } = material(web.material) ?? {};
  const stack = roll.stack ? { stack: roll.stack } : { "stack.tangential": tangential, "stack.shear": material(roll.material)?.shear };
  const rounded = Number((tension ?? nip.web_tension).toPrecision(5));
  const own = kind === "roll" ? { web_thickness: web.thickness, wound_on_tension: rounded }
    : Object.fromEntries(fieldsOf(catalogue, catalogue.kinds.find(({ name }) => name === kind).form).map(({ name }) => [name, nip[name]]));
  const values = { ...own, radius: roll.radius, "core.radius": roll.core_radius, ...stack };
  return Object.fromEntries(Object.entries(values).filter(([, value]) => value !== undefined));
}

/** A value to start a field from, keeping what an earlier description had of the same name. */
export function started(catalogue, field, before, holder) {
  const own = held(field, holder);
  if (own.type === "member") {
    if (own.number) return own.default ?? middle(own);
    // of materials the one that asks for the fewest numbers
    const size = (member) => fieldsOf(catalogue, member.form).filter((one) => !one.optional).length;
    const member = own.named ? [...own.members].sort((a, b) => size(a) - size(b))[0] : own.members[0];
    return startedMember(catalogue, own, member, before);
  }
  if (own.type === "members" && !own.optional) return [startedMember(catalogue, own, own.members[0], before)];
  if (own.default != null) return own.default;
  if (own.optional) return undefined;
  if (own.type === "choice") return own.choices[0];
  return middle(own);
}

export function startedMember(catalogue, field, member, before) {
  const table = { ...(catalogue.forms[member.form].start ?? {}) };
  for (const inner of fieldsOf(catalogue, member.form)) {
    const old = before?.[inner.name];
    if (old !== undefined && fits(inner, old)) table[inner.name] = old;
    else if (table[inner.name] === undefined && !isLeftOut(inner)) {
      const value = started(catalogue, inner, before, field);
      if (value !== undefined) table[inner.name] = value;
    }
  }
  return member.kind === null ? table : { kind: member.kind, ...table };
}

/** An optional description without a default, such as the rider of a winder, is added by the user. */
const isLeftOut = (field) => field.type === "member" && field.optional && field.default == null;

function fits(field, value) {
  if (field.type === "number") return typeof value === "number";
  if (field.type === "choice") return field.choices.includes(String(value));
  if (field.type === "members" || field.type === "numbers" || field.type === "pairs") return Array.isArray(value);
  return true;
}

/** The middle of the usual range, in two digits. */
function middle(field) {
  const [low, high] = field.typical ?? [field.limits?.ge ?? 0, field.limits?.le ?? 1];
  const value = low > 0 && high / low > 20 ? Math.sqrt(low * high) : (low + high) / 2;
  return Number(value.toPrecision(2));
}

/** The groups of a kind's form: descriptions apart, plain fields by what they are about. */
export function groupsOf(catalogue, kind, titles) {
  const groups = [];
  const plain = new Map();
  const inTable = new Map(Object.entries(kind.groups ?? {}).flatMap(([group, names]) => names.map((name) => [name, group])));
  for (const field of fieldsOf(catalogue, kind.form)) {
    const own = field.type === "member" && !field.number && !field.choices?.length && !inTable.has(field.name);
    if (own) {
      groups.push({ name: field.name, title: titles[field.name] ?? field.label, fields: [field] });
      continue;
    }
    const name = inTable.get(field.name) ?? (/friction$/.test(field.name) ? "friction" : "operation");
    if (!plain.has(name)) plain.set(name, { name, title: titles[name] ?? name, fields: [] });
    plain.get(name).fields.push(field);
  }
  const order = ["operation", "friction"];
  const rank = (group) => (order.indexOf(group.name) + order.length + 1) % (order.length + 1);
  const scalars = [...plain.values()].sort((a, b) => rank(a) - rank(b));
  return [...scalars.filter((group) => group.name === "operation"), ...groups,
    ...scalars.filter((group) => group.name !== "operation")];
}
