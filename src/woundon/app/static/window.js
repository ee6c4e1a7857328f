// The operating window: the probability that a roll keeps its limits, over two or three set points.
import * as api from "./api.js";
import { at, changed } from "./cases.js";
import { html, useState } from "./html.js";
import { atCore, isSchedule } from "./schedules.js";
import { ValueMap } from "./plane.js";
import { RunButtons, runStudy, StudyState } from "./progress.js";
import { End } from "./study.js";
import { T } from "./texts.js";
import { digits } from "./units.js";
import { labelOf } from "./variables.js";

const TENSION = "web_tension";
const loadOf = ({ winder }) => (winder ? "winder.rider_load" : "nip_load"); // the second range
const SPLIT = "torque_split";
const OSCILLATION = "oscillation";
const VARIATION = "thickness_profile.variation"; // the size of a band
const USUAL = { [SPLIT]: [0, 0.5], [VARIATION]: [0.5, 2] };
const MOVED = 0.1; // the largest usual oscillation, of the width

/** The fields of a winding that may be set points; those of the thickness if it has a profile. */
const setPoints = (tables) => [TENSION, loadOf(tables), SPLIT, ...(tables.thickness_profile ? [OSCILLATION, VARIATION] : [])];
const widthOf = ({ thickness_profile: { position } }) => position.at(-1) - position[0];
const PROBABILITY = { label: T.window.probability, unit: "1", shown_unit: "" };

/** The label of a set point: of a schedule that changes over the radius, its value at the core. */
function labelAt(store, path) {
  const field = store.fieldAt(path);
  const label = labelOf({ path, field });
  const changes = field.members?.some((member) => isSchedule(member.form)) && typeof at(store.state.case, path) === "object";
  return changes ? T.window.atCore(label) : label;
}

export function Window({ store }) {
  const { state, units, catalogue } = store;
  const [ends, setEnds] = useState({});
  const [grade, setGrade] = useState("");
  const [picked, setPicked] = useState([]); // the set points that were chosen in place of the usual ones
  if (state.kind !== "winding") return html`<p class="quiet">${T.window.onlyWindings}</p>`;
  const found = state.window;
  const around = (name) => {
    const [value, factors] = name === OSCILLATION ? [widthOf(state.case), [0, MOVED]] : [atCore(at(state.case, name)), [0.5, 1.5]];
    return factors.map((factor) => Number((factor * value).toPrecision(3)));
  };
  const rangeOf = (name) => ends[name] ?? USUAL[name] ?? around(name);
  const known = setPoints(state.case);
  const chosenNames = [TENSION, loadOf(state.case), ""].map((usual, k) => (picked[k] === "" || known.includes(picked[k]) ? picked[k] : usual));
  const names = chosenNames.filter(Boolean);
  const chosen = grade || store.grade || catalogue.grades[0].name;
  const ready = names.every((name) => { const [low, high] = rangeOf(name); return Number.isFinite(low) && high > low; });
  const run = () => {
    const body = { case: state.case, uncertain: chosen, vary: Object.fromEntries(names.map((name) => [name, rangeOf(name)])) };
    const take = (event) => (event.event === "window" ? { map: event } : {});
    return runStudy(store, "window", (handle, signal) => api.operatingWindow(body, handle, signal), take);
  };
  const box = (name, k) => html`<${End} ...${{ store, id: `window-${name}-${k}`, words: k ? T.study.to : T.study.from, field: store.fieldAt(name), value: rangeOf(name)[k],
    put: (value) => setEnds({ ...ends, [name]: rangeOf(name).map((end, n) => (n === k ? value : end)) }) }} />`;
  const pick = (k) => (event) => setPicked([0, 1, 2].map((n) => (n === k ? event.target.value : picked[n])));
  const axis = (name, k) => html`<div class="axis-row" key=${k}><label class="stacked">${T.window.axes[k]}<select id=${`window-axis-${k}`} value=${name} onChange=${pick(k)}>
    ${k === 2 && html`<option value="" selected=${!name}>${T.study.none}</option>`}
    ${known.filter((one) => one === name || !names.includes(one)).map((one) => html`<option value=${one} selected=${one === name}>${labelAt(store, one)}</option>`)}</select></label>
    ${name && [box(name, 0), box(name, 1)]}</div>`;
  return html`<section class="tab-card window"><h2>${T.window.title}</h2><p class="quiet">${T.window.about}</p>
    <div class="study-form">${chosenNames.map(axis)}
      <div class="axis-row"><label class="stacked">${T.window.spreads}<select id="window-grade" value=${chosen} onChange=${(event) => setGrade(event.target.value)}>
        ${catalogue.grades.map(({ name, title }) => html`<option value=${name} selected=${name === chosen}>${title}</option>`)}</select></label>
        <${RunButtons} ...${{ name: "window", study: found, words: T.window.run, ready, run }} /></div></div>
    <${StudyState} ...${{ store, study: found, words: found && T.window.progress(found.done, found.of) }} />
  </section>
  ${found?.map && html`<${WindowMap} store=${store} map=${found.map} />`}`;
}

/** Values over the first two axes at one level of the third, if there is one. */
const atLevel = (values, levels, level) => values.filter((_, k) => k % levels === level);

function WindowMap({ store, map }) {
  const { units } = store;
  const levels = map.axes[2] ?? [0];
  const bestLevel = Math.max(0, levels.indexOf(map.best.values[map.names[2]]));
  const [chosen, choose] = useState(null); // the level of the highest probability until another one is chosen
  const level = chosen ?? bestLevel;
  const [probabilities, bound, dominant] = [map.probability, map.binding, map.dominant].map((values) => atLevel(values, levels.length, level));
  const axis = (k) => ({ path: map.names[k], field: { ...store.fieldAt(map.names[k]), label: labelAt(store, map.names[k]) }, values: map.axes[k] });
  const titleOf = (name) => store.state.result?.margins?.find((margin) => margin.name === name)?.title ?? name.replaceAll("_", " ");
  const binding = (i, j) => {
    const place = i * map.axes[1].length + j;
    if (bound[place] < 0) return `; ${T.window.none}`;
    const input = dominant[place] < 0 ? "" : `, ${T.window.mainly(map.inputs[dominant[place]])}`;
    return `; ${T.window.binding(titleOf(map.margins[bound[place]]))}${input}`;
  };
  const { values, probability, binding: least, contributions } = map.best;
  const best = map.names.map((name) => `${store.fieldAt(name).label} ${digits(units.shown(store.fieldAt(name), values[name]), 4)} ${units.text(store.fieldAt(name))}`).join(", ");
  const third = map.names[2] && axis(2).field;
  const [input, share] = Object.entries(contributions)[0] ?? [];
  const take = () => store.take("winding", map.names.reduce((tables, name) => changed(tables, name, Number(values[name].toPrecision(4))), store.state.case));
  return html`<section class="tab-card"><p class="answer">${T.window.best(digits(probability, 2), best)} <button type="button" onClick=${take}>${T.window.take}</button></p>
    <p>${T.window.binding(titleOf(least)).replace(/^b/, "B")}${input ? `; ${T.window.contributes(input, digits(100 * share, 2))}` : ""}</p>
    <ul class="remarks">${map.remarks.map((line) => html`<li key=${line}>${units.sentence(line)}</li>`)}</ul>
    ${third && html`<label class="stacked">${third.label}<select id="window-level" value=${level} onChange=${(event) => choose(Number(event.target.value))}>
      ${levels.map((value, k) => html`<option value=${k} selected=${k === level}>${digits(units.shown(third, value), 3)} ${units.text(third)}</option>`)}</select></label>`}</section>
    <${ValueMap} ...${{ store, x: axis(0), y: axis(1), values: probabilities, quantity: PROBABILITY, note: binding, range: [0, 1] }} />`;
}
