// Schedules over the radius of a roll: a number, a taper, or points.

const POINTS = 5; // of a schedule that was a number or a taper
const PROFILE = "Profile"; // the description that is points

export const isSchedule = (form) => form === PROFILE;

/** The fields that may follow a schedule over the radius. */
export function schedulesOf(store) {
  const fields = store.catalogue.forms[store.kind.form].fields;
  return fields.filter((field) => field.members?.some((member) => isSchedule(member.form)));
}

/** The value of a schedule at the core; that of a number is the number. */
export const atCore = (value) => (typeof value === "number" ? value : value?.start ?? value?.value?.[0] ?? NaN);

/** From the core to the surface of the roll. */
export function endsOf(tables) {
  return [tables.core?.radius ?? tables.roll?.core_radius ?? 0, tables.radius];
}

/** Points (radius, value) of whatever the schedule is. */
export function pointsOf(value, [core, surface]) {
  if (value && Array.isArray(value.radius)) return value.radius.map((radius, k) => [radius, value.value[k]]);
  const radii = Array.from({ length: POINTS }, (_, k) => core + ((surface - core) * k) / (POINTS - 1));
  if (typeof value === "number") return radii.map((radius) => [radius, value]);
  const { start, taper = 0, law } = value ?? {};
  const laws = {
    linear: (r) => start * (1 - (taper * (r - core)) / (surface - core)),
    hyperbolic: (r) => start * (1 - taper * (1 - core / r)),
    constant_torque: (r) => (start * core) / r,
  };
  return radii.map((radius) => [radius, (laws[law] ?? laws.linear)(radius)]);
}

/** What stands for points (radius, value) in a case. */
export function profile(points) {
  return { radius: points.map(([r]) => Number(r.toPrecision(9))), value: points.map(([, v]) => Number(v.toPrecision(4))) };
}

/** The points that a schedule of another form goes through. */
export function profileOf(store, path, value) {
  return profile(pointsOf(value, endsOf(store.state.case)));
}

/** As many points as are dragged, on the lines between more. */
export function fewer(points, [core, surface]) {
  return Array.from({ length: POINTS }, (_, n) => {
    const r = core + ((surface - core) * n) / (POINTS - 1);
    const k = Math.max(1, points.findIndex(([next]) => next >= r * (1 - 1e-9)));
    const [[r0, v0], [r1, v1]] = [points[k - 1], points[k]];
    return [r, v0 + ((v1 - v0) * Math.min(1, Math.max(0, (r - r0) / (r1 - r0))))];
  });
}
