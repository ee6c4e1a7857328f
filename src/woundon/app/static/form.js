// The form of a case, generated from the catalogue.
import { at, fieldsOf, groupsOf, held, memberOf, started, startedMember } from "./cases.js";
import { scheduleOf } from "./schedules.js";
import { html, useEffect, useMemo } from "./html.js";
import { Label, Symbol } from "./symbols.js";
import { T } from "./texts.js";
import { plain, QuantityBox, readQuantity, useTyped } from "./quantity.js";
import { digits, parsed, typeset } from "./units.js";

const STEPS = 1000; // of a slider
const LOGARITHMIC = 50; // the ratio of its ends from which a slider goes by ratios

const PLAIN = { unit: "1", shown_unit: "" };

const idOf = (path) => `f-${path.replaceAll(".", "-")}`;

export function Form({ store }) {
  const { catalogue, kind } = store;
  const narrow = matchMedia("(max-width: 820px)").matches;
  // on a phone the first group of a nip alone is open: results and the fields of a study come below
  const shut = narrow && store.state.tab !== "case";
  return html`<form class="form" aria-label=${T.form.name} onSubmit=${(event) => event.preventDefault()}>
    ${kind.has_grades && html`<label class="grade">${T.form.grade}<select id="grade" value=${store.grade} onChange=${(event) => event.target.value && store.fillGrade(event.target.value)}>
      <option value="" selected=${!store.grade}>${T.form.chooseGrade}</option>
      ${catalogue.grades.map(({ name, title }) => html`<option value=${name} selected=${name === store.grade}>${typeset(title.charAt(0).toUpperCase() + title.slice(1))}</option>`)}</select></label>`}
    ${groupsOf(catalogue, kind, T.groups).map((group, k) => html`<${Group} key=${`${kind.name}.${group.name}.${shut}`} ...${{ store, group, open: !narrow || (k === 0 && !shut) }} />`)}
  </form>`;
}

/** Redrawn only if one of its own fields has changed: a slider changes one of a hundred. */
function Group({ store, group: { name, title, fields }, open }) {
  const { state, units } = store;
  return useMemo(() => html`<details class="group" open=${open} data-group=${name}>
      <summary>${title.charAt(0).toUpperCase() + title.slice(1)}</summary>
      <div class="fields">${fields.map((field) => html`<${Field} key=${field.name} ...${{ store, field, path: field.name, lone: fields.length === 1 }} />`)}</div>
    </details>`, [units, state.faults, state.misread, ...fields.map((field) => state.case[field.name])]);
}

function Field(props) {
  const { field } = props;
  if (field.type === "member") return html`<${Member} ...${props} />`;
  if (field.type === "members") return html`<${Members} ...${props} />`;
  if (field.type === "choice") return html`<${Choice} ...${props} />`;
  if (field.type === "numbers" || field.type === "pairs") return html`<${Numbers} ...${props} />`;
  return html`<${NumberField} ...${props} />`;
}

function Fault({ path, text }) {
  return text ? html`<p class="fault" id=${`${idOf(path)}-fault`} role="alert">${text}</p>` : null;
}

/** The limits in the units that are shown. */
function limitsText(units, field) {
  const signs = { gt: ">", ge: "≥", lt: "<", le: "≤" };
  const limits = Object.entries(signs).filter(([name]) => field.limits?.[name] != null)
    .map(([name, sign]) => `${sign} ${digits(units.shown(field, field.limits[name]), 6)}`);
  return (limits.join(` ${T.and} `) || T.form.finite) + (units.text(field) ? ` ${units.text(field)}` : "");
}

function within(field, value) {
  const { gt, ge, lt, le } = field.limits ?? {};
  return (gt == null || value > gt) && (ge == null || value >= ge) && (lt == null || value < lt) && (le == null || value <= le);
}

// ---- a number ----

/** Let the store keep the error of a text that has no value, until the value or the units change. */
function useMisread(store, path, value) {
  const setFault = (fault) => store.misread(path, fault);
  useEffect(() => () => setFault(""), [path, value, store.units.name]);
  return setFault;
}

function NumberField({ store, field, path }) {
  const { units, state } = store;
  const value = at(state.case, path);
  const setFault = useMisread(store, path, value);
  const unit = units.text(field);
  const start = at(store.kind.example, path);
  const error = store.faultAt(path);

  const read = (text) => {
    const { value: si, fault } = readQuantity(store, field, text, limitsText(units, field));
    return fault || within(field, si) ? { value: si, fault } : { fault: T.form.outOfRange(text, limitsText(units, field)) };
  };
  const put = (si, fault) => {
    setFault(fault ?? "");
    if (fault) return value;
    store.change(path, si, { moving: true });
    return si;
  };
  const leave = () => { store.moving = false; };
  const known = start !== undefined || field.optional; // something to go back to
  const differs = known && (error || value !== start);

  return html`<div class=${`field number${error ? " wrong" : ""}`} data-path=${path}>
    <label for=${idOf(path)}><${Label} of=${field.label} /> <span class="symbol"><${Symbol} of=${field.symbol} /></span></label>
    ${field.typical ? html`<${Slider} ...${{ store, field, path, value, unit }} />` : html`<span class="no-slider"></span>`}
    <${QuantityBox} ...${{ store, quantity: field, value, put, read, optional: field.optional, wrong: error, onLeave: leave }} id=${idOf(path)} class="box"
      placeholder=${field.optional ? T.form.none : ""} aria-describedby=${error ? `${idOf(path)}-fault` : undefined} />
    <span class="unit" aria-hidden="true">${unit}</span>
    <button type="button" class="reset" title=${T.form.reset} aria-label=${`${T.form.reset}: ${field.label}`}
      disabled=${!differs} onClick=${() => { setFault(""); store.change(path, start); }}>↺</button>
    <${Fault} path=${path} text=${error} />
  </div>`;
}

function Slider({ store, field, path, value, unit }) {
  const [low, high] = field.typical;
  const log = low > 0 && high / low >= LOGARITHMIC;
  const share = value == null ? 0 : log ? Math.log(Math.max(value, 1e-300) / low) / Math.log(high / low) : (value - low) / (high - low);
  const place = Math.round(STEPS * Math.min(1, Math.max(0, share)));
  const move = (event, moving) => {
    const part = Number(event.target.value) / STEPS;
    const si = log ? low * (high / low) ** part : low + (high - low) * part;
    const { units } = store;
    const shown = Number(units.shown(field, si).toPrecision(3));
    store.change(path, part === 0 ? low : part === 1 ? high : units.si(field, shown), { moving });
  };
  return html`<input type="range" class="slider" min="0" max=${STEPS} step="1" value=${place}
    aria-label=${field.label} aria-valuetext=${`${digits(store.units.shown(field, value))} ${unit}`}
    onInput=${(event) => move(event, true)} onChange=${() => { store.moving = false; }} />`;
}

// ---- words, lists of numbers ----

function Choice({ store, field, path }) {
  const value = String(at(store.state.case, path) ?? field.default);  // also of true and false
  return html`<div class="field choice" data-path=${path}>
    <label for=${idOf(path)}>${field.label || T.fields[field.name] || field.name}</label>
    <select id=${idOf(path)} value=${value} onChange=${(event) => store.change(path, event.target.value)}>
      ${field.choices.map((word) => html`<option value=${word} selected=${word === value}>${word}</option>`)}
    </select>
    <${Fault} path=${path} text=${store.faultAt(path)} />
  </div>`;
}

/** A list of numbers, or of pairs, one a line. */
function Numbers({ store, field, path }) {
  const { units, state } = store;
  const pairs = field.type === "pairs";
  const value = at(state.case, path);
  const [typed, keep, forget] = useTyped(units, value);
  const setFault = useMisread(store, path, value);
  const rowText = (row) => (pairs ? row.map((number) => plain(units, PLAIN, number)).join("  ") : plain(units, field, row));
  const take = (text) => {
    const rows = text.split("\n").filter((row) => row.trim());
    const list = pairs ? rows.map((row) => row.trim().split(/[\s,;]+/).map(parsed)) : rows.map((row) => readQuantity(store, field, row).value);
    const wrong = pairs ? list.some((row) => row.length !== 2 || row.some(Number.isNaN)) : list.includes(undefined);
    setFault(wrong ? pairs ? T.form.pairs : T.form.numbers : "");
    if (wrong) return keep(text, value);
    const next = list.length || !field.optional ? list : undefined;
    store.change(path, next);
    return keep(text, next);
  };
  const error = store.faultAt(path);
  return html`<div class=${`field list${error ? " wrong" : ""}`} data-path=${path}>
    <label for=${idOf(path)}>${field.label || field.name} <span class="symbol"><${Symbol} of=${field.symbol || ""} /></span>
      <span class="unit">${pairs || !units.text(field) ? "" : ` [${units.text(field)}]`}</span></label>
    <textarea id=${idOf(path)} rows="4" spellcheck=${false} value=${typed ?? (value ?? []).map(rowText).join("\n")} aria-invalid=${error ? "true" : "false"}
      onInput=${(event) => take(event.target.value)} onBlur=${() => { if (!state.misread[path]) forget(); }}></textarea>
    <${Fault} path=${path} text=${error} />
  </div>`;
}

// ---- descriptions ----

const NONE = "\u0000none";
const NUMBER = "\u0000number";

function Member({ store, field, path, lone, holder }) {
  const { catalogue, state } = store;
  const value = at(state.case, path);
  const member = memberOf(catalogue, field, value);
  const words = field.choices ?? [];
  const isWord = words.includes(value);
  const named = typeof value === "string" && !isWord;
  const isNumber = typeof value === "number";
  const choices = field.members.length + words.length + (field.number ? 1 : 0) + (field.named ? 1 : 0) + (field.optional ? 1 : 0) > 1;
  const chosen = isWord ? `#${value}` : named ? `@${value}` : isNumber ? NUMBER : value == null ? NONE : member?.form;
  const change = (described) => (path === "air" ? store.chooseAir(described) : store.change(path, described));
  const choose = (event) => {
    const to = event.target.value;
    if (to === NONE) change(undefined);
    else if (to === NUMBER) store.change(path, numberOf(store, field, value));
    else if (to.startsWith("#")) store.change(path, to.slice(1));
    else if (to.startsWith("@")) store.change(path, to.slice(1));
    else if (scheduleOf(to, store, value)) store.change(path, scheduleOf(to, store, value));
    else {
      const next = field.members.find((one) => one.form === to);
      const before = named ? catalogue.materials.find((one) => one.name === value)?.material : isNumber ? { start: value } : value;
      change(startedMember(catalogue, field, next, before));
    }
  };
  const label = T.fields[field.name] ?? (field.label || field.name);
  const titleOf = (form) => T.members[form] ?? catalogue.forms[form].title;
  const source = named && catalogue.materials.find((one) => one.name === value)?.source;
  const inner = isNumber || named || isWord || !member ? [] : fieldsOf(catalogue, member.form);
  const body = html`
    ${choices && html`<div class="member-choice">
      <label for=${idOf(path)} class=${lone ? "hidden" : ""}><${Label} of=${label} /></label>
      <select id=${idOf(path)} value=${chosen} onChange=${choose}>
        ${field.optional && html`<option value=${NONE} selected=${chosen === NONE}>${T.form.none}</option>`}
        ${field.number && html`<option value=${NUMBER} selected=${chosen === NUMBER}>${T.form.oneNumber}</option>`}
        ${words.map((word) => html`<option value=${`#${word}`} selected=${word === value}>${word}</option>`)}
        ${field.members.map((one) => html`<option value=${one.form} selected=${chosen === one.form}>${titleOf(one.form)}</option>`)}
        ${field.named && html`<optgroup label=${T.form.named}>${catalogue.materials.map(({ name }) => html`<option value=${`@${name}`} selected=${chosen === `@${name}`}>${name}</option>`)}</optgroup>`}
      </select>
    </div>`}
    ${source && html`<p class="source">${typeset(source)}</p>`}
    ${isNumber && html`<${NumberField} ...${{ store, path, field: { ...field, optional: false } }} />`}
    ${inner.map((one) => html`<${Field} key=${one.name} ...${{ store, path: `${path}.${one.name}`, field: held(one, field), holder: field }} />`)}
    <${Fault} path=${path} text=${isNumber ? "" : store.faultAt(path)} />`;
  return lone ? html`<div class="member" data-path=${path}>${body}</div>`
    : html`<fieldset class="member" data-path=${path}>${!choices && html`<legend><${Label} of=${label} /></legend>`}${body}</fieldset>`;
}

function numberOf(store, field, value) {
  const inside = value?.start ?? value?.value?.[0];
  return typeof inside === "number" ? inside : started(store.catalogue, { ...field, members: [], number: true }, null);
}

/** A list of descriptions: the layers of a cover. */
function Members({ store, field, path }) {
  const { catalogue, state } = store;
  const items = at(state.case, path) ?? [];
  const add = () => {
    const last = items.at(-1);
    store.change(path, [...items, last ? structuredClone(last) : startedMember(catalogue, field, field.members[0])]);
  };
  const fewest = field.optional ? 0 : field.min_items ?? 0;
  const drop = (k) => {
    const left = items.filter((_, other) => other !== k);
    store.change(path, left.length || !field.optional ? left : undefined);
  };
  const up = (k) => store.change(path, items.map((item, n) => (n === k - 1 ? items[k] : n === k ? items[k - 1] : item)));
  const most = field.max_items ?? 20;
  const titleOf = (member) => T.members[member.form] ?? catalogue.forms[member.form].title;
  const title = titleOf(field.members[0]);
  const ordered = /outermost/.test(field.label);
  return html`<div class="members" data-path=${path}>
    ${!ordered && html`<p class="quiet">${field.label}</p>`}
    ${items.map((item, k) => {
      const member = memberOf(catalogue, field, item) ?? field.members[0];
      return html`<fieldset class="member item" key=${k}>
        <legend>${T.form.item(titleOf(member), k + 1, items.length, ordered)}</legend>
        <div class="item-tools">
          ${ordered && html`<button type="button" disabled=${k === 0} aria-label=${T.form.outward(title, k + 1)} title=${T.form.outward(title, k + 1)} onClick=${() => up(k)}>↑</button>`}
          <button type="button" disabled=${items.length <= fewest} aria-label=${T.form.drop(title, k + 1)} title=${T.form.drop(title, k + 1)} onClick=${() => drop(k)}>✕</button>
        </div>
        ${fieldsOf(catalogue, member.form).map((one) => html`<${Field} key=${one.name} ...${{ store, path: `${path}.${k}.${one.name}`, field: one }} />`)}
      </fieldset>`;
    })}
    <button type="button" class="add" disabled=${items.length >= most} onClick=${add}>${T.form.add(title)}</button>
    <${Fault} path=${path} text=${store.faultAt(path)} />
  </div>`;
}
