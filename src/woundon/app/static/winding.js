// The winding tab: a schedule drawn by dragging its points, what the roll keeps of it, margins.
import { at } from "./cases.js";
import { DESIGNED, Design } from "./design.js";
import { Find } from "./find.js";
import { html, useState } from "./html.js";
import { Points } from "./points.js";
import { QuantityBox } from "./quantity.js";
import { Differences, MorePanels, Numbers, OnePanel, Pending, Pins, Sections, SlowPanels, states, Verdict } from "./results.js";
import { endsOf, pointsOf, profile, schedulesOf } from "./schedules.js";
import { T } from "./texts.js";
import { digits, LENGTH } from "./units.js";

export function Winding({ store }) {
  const { state } = store;
  const schedules = schedulesOf(store);
  const [chosen, choose] = useState("");
  const field = schedules.find((one) => one.name === chosen) ?? schedules[0];
  const good = state.result && state.result.kind === state.kind;
  return html`${good && html`<${Verdict} store=${store} /><${Numbers} store=${store} /><${Margins} store=${store} /><${Find} key=${state.kind} store=${store} />`}
    ${!good && html`<${Pending} store=${store} />`}
    ${field && html`<section class="tab-card schedule"><div class="axis-row"><h2>${T.winding.schedule}</h2>
        ${schedules.length > 1 && html`<label class="inline"><span class="hidden">${T.winding.schedule}</span><select value=${field.name} onChange=${(event) => choose(event.target.value)}>
          ${schedules.map((one) => html`<option value=${one.name} selected=${one.name === field.name}>${one.label}</option>`)}</select></label>`}</div>
      <${Schedule} key=${field.name} store=${store} field=${field} /></section>`}
    ${good && state.kind === DESIGNED && html`<${Design} store=${store} />`}
    ${good && html`<${Pins} store=${store} />
      <div class="panels">${state.result.panels.map((panel) => html`<div class="panel-cell" key=${panel.name}><${OnePanel} store=${store} name=${panel.name} height=${230}
        cases=${states(store, (one) => one.result.panels.find((other) => other.name === panel.name))} /></div>`)}<${SlowPanels} store=${store} /></div><${MorePanels} store=${store} />
      <${Differences} store=${store} /><${Sections} store=${store} />`}`;
}

const MARKS = { good: "✓", bad: "✗", open: "–" };
const word = ({ ok }) => (ok == null ? "open" : ok ? "good" : "bad");

function Margins({ store }) {
  const { margins } = store.state.result;
  if (!margins?.length) return null;
  const { units } = store;
  return html`<section class="tab-card"><h2>${T.winding.margins}</h2><div class="table-scroll" tabindex="0"><table class="margins"><thead><tr>
      <th scope="col"></th><th scope="col">${T.results.value}</th><th scope="col">${T.winding.limit}</th><th scope="col">${units.label(T.winding.radius, LENGTH)}</th><th scope="col"></th></tr></thead>
    <tbody>${margins.map((margin) => {
      const { quantity } = margin;
      const text = (value) => (value == null ? "–" : `${digits(units.shown(quantity, value))} ${units.text(quantity)}`);
      return html`<tr key=${margin.name} class=${word(margin)} title=${[units.sentence(margin.note), margin.hint].filter(Boolean).join("; ")}><th scope="row">${margin.title}<span class="quiet"> ${quantity.label}</span></th><td>${text(margin.value)}</td><td><${Limit} ...${{ store, margin, text }} /></td>
        <td>${margin.radius == null ? "–" : digits(units.shown(LENGTH, margin.radius), 4)}</td><td><span class="mark" aria-hidden="true">${MARKS[word(margin)]}</span> <span class="verdict">${T.winding[word(margin)]}</span></td></tr>`;
    })}</tbody></table></div>
    ${!store.grade && margins.filter(({ limit }) => limit == null).length > margins.length / 2 && html`<p class="quiet">${T.winding.noLimits}</p>`}</section>`;
}

/** The limit of a margin, next to its value; it is a field of the case. */
function Limit({ store, margin, text }) {
  const { units } = store;
  const path = margin.limit_field;
  const known = path && store.fieldAt(path);
  if (!known) return text(margin.limit);
  const field = { ...known, shown_unit: margin.quantity.shown_unit }; // the unit of the value next to it
  const value = at(store.state.case, path);
  const put = (si, fault) => {
    if (fault) return value;
    store.change(path, si, { moving: true });
    return si;
  };
  const unset = value === undefined && margin.limit != null; // a limit that follows from the case, as of the core
  return html`<span class="limit"><${QuantityBox} ...${{ store, quantity: field, value, put, optional: true, onLeave: () => { store.moving = false; } }} id=${`limit-${margin.name}`}
      aria-label=${`${T.winding.limit}: ${margin.title}`} placeholder=${unset ? digits(units.shown(field, margin.limit), 4) : T.form.none} /> ${units.text(field)}</span>`;
}

/** A schedule of the case, as points to drag. */
function Schedule({ store, field }) {
  const value = at(store.state.case, field.name);
  const ends = endsOf(store.state.case);
  const points = pointsOf(value, ends);
  const put = (next, moving) => store.change(field.name, profile(next), { moving });
  return html`<${Points} ...${{ store, quantity: field, points, ends, put, name: `${T.winding.schedule}: ${field.label}` }}
    own=${Array.isArray(value?.radius)} usual=${field.typical?.[0] ?? 0} least=${field.limits?.ge ?? 0} rest=${() => { store.moving = false; }} />`;
}
