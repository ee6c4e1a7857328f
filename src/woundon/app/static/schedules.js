// Schedules over the radius of a roll: a number, a taper, steps, or points.

const POINTS = 5; // of a schedule that was a number or a taper
const PROFILE = "Profile"; // the description that is points
const STEPS = "Steps"; // the description that is steps
const RAMP = 0.001; // of steps [m], by default
const HARD_CORE = 0.02; // depth of the first step [m]; of a smaller roll a quarter

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
  if (value && Array.isArray(value.depth)) return cornersOf(value, core, surface);
  const radii = Array.from({ length: POINTS }, (_, k) => core + ((surface - core) * k) / (POINTS - 1));
  if (typeof value === "number") return radii.map((radius) => [radius, value]);
  const { start, taper = 0, law, exponent = 0 } = value ?? {};
  const laws = {
    linear: (r) => start * (1 - (taper * (r - core)) / (surface - core)),
    hyperbolic: (r) => start * (1 - taper * (1 - core / r)),
    constant_torque: (r) => (start * core) / r,
    power: (r) => start * (core / r) ** exponent,
  };
  return radii.map((radius) => [radius, (laws[law] ?? laws.linear)(radius)]);
}

/** Points (radius, value) at both ends of each ramp of steps, and at core and surface. */
function cornersOf({ depth, value, ramp = RAMP }, core, surface) {
  const ramps = depth.flatMap((d, k) => [[core + d, value[k]], [core + d + ramp, value[k + 1]]]);
  return [[core, value[0]], ...ramps.filter(([r]) => r < surface), [surface, value.at(-1)]];
}

/** Steps that begin and end with the values of another schedule. */
function stepsOf(value, ends) {
  const points = pointsOf(value, ends);
  const depth = Math.min(HARD_CORE, Number(((ends[1] - ends[0]) / 4).toPrecision(2)));
  return { value: [points[0][1], points.at(-1)[1]], depth: [depth], ramp: RAMP };
}

/** What stands for points (radius, value) in a case. */
export function profile(points) {
  return { radius: points.map(([r]) => Number(r.toPrecision(9))), value: points.map(([, v]) => Number(v.toPrecision(4))) };
}

/** A schedule of this form that resembles one of another form; undefined for other forms. */
export function scheduleOf(form, store, value) {
  const ends = endsOf(store.state.case);
  if (form === PROFILE) return profile(pointsOf(value, ends));
  if (form === STEPS) return stepsOf(value, ends);
  return undefined;
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
