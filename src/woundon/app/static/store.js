// The state of the page: the case, its history, the last valid result, the pinned states.
import * as api from "./api.js";
import { at, changed, fieldsOf, held, memberOf, ofNip, same, started } from "./cases.js";
import { useEffect, useState } from "./html.js";
import { atCore } from "./schedules.js";
import { T } from "./texts.js";
import { Units, usual } from "./units.js";
import { curveOutputs } from "./variables.js";

const PINS = 4;
const REST = 220; // [ms] without a change, after which slower answers are requested
const KEPT = 200; // steps of undo
const RETRY = 1500; // [ms] between requests to a server that does not respond
export const TABS = ["case", "study", "fit", "winding", "window", "thesis"];
export const ROLLS = ["roll", "winding"]; // shown in a tab of their own, the quick one first
const NO_FAULTS = Object.freeze({});

export class Store {
  constructor(catalogue) {
    this.catalogue = catalogue;
    this.listeners = new Set();
    this.newest = new api.Newest();
    this.wanted = new Set();
    const first = catalogue.kinds.find((kind) => kind.name === "nip") ?? catalogue.kinds[0];
    this.state = {
      kind: first.name, case: first.example, system: kept("system", "SI"), theme: kept("theme", ""),
      tab: "case", past: [], future: [], faults: NO_FAULTS, misread: NO_FAULTS, problem: "",
      result: null, solved: null, extras: {}, busy: false, rough: false, pins: [], tables: false,
      others: {}, study: null, fit: null, window: null, message: "", grade: null, lost: "", notice: "",
    };
    this.units = new Units(catalogue, this.state.system);
    api.connection.lost = () => this.reconnect();
  }

  set(patch) {
    this.state = { ...this.state, ...patch };
    if (patch.system) this.units = new Units(this.catalogue, patch.system);
    for (const listener of this.listeners) listener();
  }

  kindOf(name) {
    return this.catalogue.kinds.find((kind) => kind.name === name);
  }

  get kind() {
    return this.kindOf(this.state.kind);
  }

  output(name, kind = this.kind) {
    const found = kind.outputs.find((output) => output.name === name);
    return found ?? { name, symbol: name, label: name, unit: "1", shown_unit: "" };
  }

  /** The field of a dotted path of the case; null where there is none. */
  fieldAt(path) {
    return this.fieldOf(this.state.kind, this.state.case, path);
  }

  /** The field of a dotted path of some case. */
  fieldOf(kind, tables, path) {
    const { catalogue } = this;
    let fields = fieldsOf(catalogue, this.kindOf(kind).form);
    let table = tables;
    let holder = null;
    for (const name of path.split(".")) {
      if (/^\d+$/.test(name)) {
        if (!holder?.members) return null;
        table = table?.[name];
        fields = fieldsOf(catalogue, (memberOf(catalogue, holder, table) ?? holder.members[0]).form);
        continue;
      }
      const found = fields.find((one) => one.name === name);
      if (!found) return null;
      const field = held(found, holder);
      table = table?.[name];
      const member = field.members && !Array.isArray(table) ? memberOf(catalogue, field, table) : null;
      holder = field;
      fields = member ? fieldsOf(catalogue, member.form) : [];
    }
    return holder;
  }

  // ---- errors ----

  /** Set the error of a text that was typed into a field and has no value; "" clears it. */
  misread(path, fault) {
    const { [path]: before = "", ...others } = this.state.misread;
    if (before !== fault) this.set({ misread: fault ? { ...others, [path]: fault } : others });
  }

  /** The error of a field, or of an item of its list, in the units that are shown. */
  faultAt(path) {
    const { faults, misread } = this.state;
    if (misread[path]) return misread[path];
    const found = Object.keys(faults).find((one) => one === path || (one.startsWith(`${path}.`) && /^\d+$/.test(one.slice(path.length + 1))));
    return found ? this.messageOf(found, faults[found]) : "";
  }

  /** The server's message about a field in the units that are shown. */
  messageOf(path, { message, unit }) {
    return this.units.message(message, this.fieldAt(path) ?? (unit ? usual(unit) : null));
  }

  /** An error of the server in the units that are shown. */
  textOf(fault) {
    return (fault.errors ?? []).map(({ field, message, unit }) => `${field && `${field}: `}${this.messageOf(field, { message, unit })}`).join("\n") || fault.message;
  }

  /** All errors of the case: {label, text}. */
  get errors() {
    const { faults, misread, problem } = this.state;
    const known = [...Object.entries(faults).map(([path, fault]) => [path, this.messageOf(path, fault)]), ...Object.entries(misread)];
    return [...(problem ? [{ label: "", text: problem }] : []),
      ...known.map(([path, text]) => ({ label: this.fieldAt(path)?.label || path, text }))];
  }

  // ---- the case ----

  /** Change one field; a slider that moves makes one step of undo. */
  change(path, value, { moving = false } = {}) {
    const next = changed(this.state.case, path, value);
    if (same(next, this.state.case)) return;
    const { past } = this.state;
    const step = past.at(-1);
    const merged = moving && step?.path === path && this.moving;
    this.moving = moving;
    this.changedPath = path; // the field from which studies and searches start
    this.set({
      case: next, future: [], notice: "",
      past: merged ? past : [...past, { path, kind: this.state.kind, case: this.state.case }].slice(-KEPT),
    });
    this.solve(moving);
  }

  /** Choose entrained air, or none (undefined); with air the web needs a speed, without air it may not have one. */
  chooseAir(air) {
    const tables = changed(this.state.case, "air", air);
    const speed = this.fieldAt("web_speed");
    if (air !== undefined && tables.web_speed === undefined) {
      this.speedOfAir = true;
      this.take(this.state.kind, changed(tables, "web_speed", started(this.catalogue, { ...speed, optional: false })));
    } else if (air === undefined && this.speedOfAir) {
      this.speedOfAir = false;
      this.take(this.state.kind, changed(tables, "web_speed", undefined));
    } else this.take(this.state.kind, tables);
  }

  /** Take a whole case: another kind, one from a file or a link. */
  take(kind, tables) {
    const past = [...this.state.past, { kind: this.state.kind, case: this.state.case }].slice(-KEPT);
    this.moving = false;
    this.set({ kind, case: tables, past, future: [], faults: NO_FAULTS, problem: "", notice: "" });
    this.solve();
  }

  /** Fill in the values of a grade; what it does not supply stays. */
  async fillGrade(name) {
    const { kind, case: tables } = this.state;
    try {
      const { problem } = await api.withGrade(tables, name);
      if (tables !== this.state.case) return;
      this.take(kind, problem);
      this.set({ grade: { name, web: webOf(problem) } });
    } catch (fault) {
      if (tables === this.state.case) this.showErrors(fault);
    }
  }

  /** The grade that was filled in, as long as the web is that of the grade. */
  get grade() {
    const { grade, case: tables } = this.state;
    return grade && same(grade.web, webOf(tables)) ? grade.name : "";
  }

  undo() {
    this.step("past", "future");
  }

  redo() {
    this.step("future", "past");
  }

  step(from, to) {
    const last = this.state[from].at(-1);
    if (!last) return;
    this.moving = false;
    const here = { path: last.path, kind: this.state.kind, case: this.state.case };
    this.set({
      [from]: this.state[from].slice(0, -1), [to]: [...this.state[to], here],
      kind: last.kind, case: last.case, faults: NO_FAULTS, problem: "",
    });
    this.solve();
  }

  /** Show a tab, with a case of a kind that it has: a roll starts with the values of the nip. */
  show(tab) {
    const { kind } = this.state;
    const isRoll = ROLLS.includes(kind);
    this.set({ tab });
    if (tab === "window" && kind !== "winding") this.goTo("winding");
    if (tab === "winding" && !isRoll) this.goTo(ROLLS.find((one) => this.kindOf(one)));
    if (tab === "case" && isRoll) this.goTo("nip");
  }

  /** Change the kind; values that both kinds have stay, a schedule with its value at the core. */
  async goTo(name) {
    const { case: now, kind, others, result, solved, tab } = this.state;
    const next = this.kindOf(name);
    if (kind === "nip") this.tensionOfNip = solved === now ? result.outputs.roll_wound_on_tension?.value : undefined;
    const { grade } = this;
    const fields = new Map(fieldsOf(this.catalogue, next.form).map((field) => [field.name, field]));
    let before = others[name] ?? next.example;
    if (grade && next.has_grades && !same(webOf(before), webOf(now))) { // else the roll would be of another paper
      before = await api.withGrade(before, grade).then((answer) => answer.problem, () => before);
      if (now !== this.state.case || tab !== this.state.tab) return; // left for another meanwhile
    }
    const carried = ([path, value]) => {
      if (fields.get(path).type === "number" && typeof value === "object") return [path, atCore(value)];
      return [path, value === atCore(before[path]) ? before[path] : value]; // a schedule from this value stays
    };
    const shared = Object.entries(now).filter(([field]) => fields.has(field) && field in before).map(carried);
    const related = "web_tension" in now && "web_tension" in before; // a nip and a winding, not a roll and a winding
    this.set({ others: { ...others, [kind]: now } });
    const tables = this.withNip(name, related ? { ...before, ...Object.fromEntries(shared) } : before);
    this.take(name, tables);
    if (grade && next.has_grades) this.set({ grade: { name: grade, web: webOf(tables) } });
  }

  /** A roll or a winding with the values of the nip, or those that have changed since it had them. */
  withNip(name, tables) {
    const { nip } = this.state.others;
    if (!ROLLS.includes(name) || !nip || same(nip, this.kindOf("nip").example)) return tables;
    const values = ofNip(this.catalogue, name, nip, this.tensionOfNip);
    const before = this.carried?.[name] ?? {};
    this.carried = { ...this.carried, [name]: values };
    return Object.entries(values).filter(([path, value]) => !same(value, before[path]) && atCore(at(tables, path)) !== value)
      .reduce((inner, [path, value]) => changed(inner, path, value), tables);
  }

  // ---- the picture ----

  /** Solve; while a slider moves, each solve starts from the previous one; at rest it is solved again without. */
  solve(moving = false) {
    clearTimeout(this.resting);
    this.filling?.abort();
    const tables = this.state.case;
    const kind = this.state.kind;
    this.set({ busy: true });
    this.newest.ask(async (signal) => {
      await this.solved(kind, tables, moving ? { warm: true } : {}, signal);
      // from the picture on: on a slow machine a rest from the change on would begin before it
      // still busy then: a request that was sent before, and came after it, took its place
      if (tables === this.state.case) this.resting = setTimeout(() => (this.state.busy ? this.solve() : this.rest(moving)), REST);
    });
  }

  async solved(kind, tables, options, signal) {
    try {
      const result = await api.solve(tables, options, signal);
      if (kind !== this.state.kind) return;
      this.set({ result, solved: tables, busy: this.newest.waiting !== null, rough: !!options.warm, faults: NO_FAULTS, problem: "" });
      if (options.report) this.keep("report", tables, result);
    } catch (fault) {
      if (fault.name === "AbortError" || fault.superseded) return;
      if (tables !== this.state.case) return;
      this.showErrors(fault);
    }
  }

  /** Show the errors of a request at their fields; the last valid results stay. */
  showErrors(fault) {
    const faults = {};
    const left = [];
    for (const { field, message, unit } of fault.errors) {
      if (field) faults[field] = { message, unit };
      else left.push(this.units.message(message));
    }
    if (!fault.errors.length) left.push(fault.message);
    this.set({ faults, problem: left.join("\n"), busy: false, rough: false });
  }

  /** Wait until the server responds, then solve again. */
  async reconnect() {
    if (this.state.lost) return;
    this.set({ lost: T.lost.stopped(location.host) });
    let catalogue = null;
    while (!catalogue) {
      await new Promise((resolve) => setTimeout(resolve, RETRY));
      try {
        catalogue = await api.catalogue();
      } catch (fault) {
        if (fault.status === 401) this.set({ lost: T.lost.token });
      }
    }
    if (catalogue.version !== this.catalogue.version) return this.set({ lost: T.lost.version(catalogue.version) });
    this.set({ lost: "", extras: {} }); // answers that failed among them
    this.say(T.lost.back);
    return this.solve();
  }

  /** At rest: the converged result, then slower answers that are in sight. */
  rest(moving) {
    const { kind, case: tables } = this.state;
    const fill = () => { if (tables === this.state.case && tables === this.state.solved) this.fill(); };
    if (!moving) return fill();
    return this.newest.ask(async (signal) => {
      await this.solved(kind, tables, { report: true }, signal);
      if (this.state.rough && tables === this.state.case) this.resting = setTimeout(() => this.rest(moving), REST);
      else fill();
    });
  }

  /** A slower answer has come into sight, or out of sight. */
  want(name, inSight) {
    if (inSight) this.wanted.add(name);
    else this.wanted.delete(name);
    if (inSight && !this.state.busy) this.fill();
  }

  /** An additional answer; it is stale if it is that of an earlier case. */
  extra(name) {
    const found = this.state.extras[name];
    const known = found?.kind === this.state.kind ? found : null;
    return { answer: known?.answer ?? null, stale: known?.of !== this.state.case };
  }

  async fill() {
    if (this.filling && !this.filling.signal.aborted) return;
    this.filling = new AbortController();
    const { signal } = this.filling;
    const tables = this.state.case;
    const field = this.loadOf(this.kind);
    const ask = {
      report: () => api.solve(tables, { report: true }, signal),
      curve: () => field && api.curve(tables, { field, points: 13, outputs: curveOutputs(this.kind, this.state.result).join() }, signal),
      bars: () => field && api.sensitivities(tables, signal),
    };
    for (;;) {
      const name = ["report", ...this.wanted].find((one) => this.extra(one).stale);
      if (!name || signal.aborted || tables !== this.state.case) break;
      const answer = await Promise.resolve(ask[name]()).catch(() => null);
      if (signal.aborted || tables !== this.state.case) break;
      this.keep(name, tables, answer);
    }
    if (this.filling?.signal === signal) this.filling = null;
  }

  keep(name, of, answer) {
    this.set({ extras: { ...this.state.extras, [name]: { kind: this.state.kind, of, answer } } });
  }

  /** The field against which the outputs are drawn around the working point. */
  loadOf(kind) {
    const fields = this.catalogue.forms[kind.form].fields;
    return fields.find((field) => /load$/.test(field.name))?.name ?? null;
  }

  // ---- pinned states ----

  pin() {
    const { pins, result, solved, kind } = this.state;
    if (!result || pins.length >= PINS) return;
    const free = ["A", "B", "C", "D"].find((label) => !pins.some((pin) => pin.label === label));
    this.set({ pins: [...pins, { label: free, kind, case: solved, result, extras: this.state.extras }] });
  }

  unpin(label) {
    this.set({ pins: this.state.pins.filter((pin) => pin.label !== label) });
  }

  get full() {
    return this.state.pins.length >= PINS;
  }

  /** Pinned states of the kind that is seen. */
  get pinned() {
    return this.state.pins.filter((pin) => pin.kind === this.state.kind);
  }

  prefer(name, value) {
    try { localStorage.setItem(`woundon.${name}`, value); } catch { /* private windows */ }
    this.set({ [name]: value });
  }

  /** Show a short message, which screen readers read too. */
  say(message) {
    clearTimeout(this.saying);
    this.set({ message });
    this.saying = setTimeout(() => this.set({ message: "" }), 4000);
  }
}

/** The web of a case: that of a nip or a winding, or the stack of a roll. */
const webOf = ({ web, stack, web_thickness }) => ({ web, stack: web ? null : stack, web_thickness });

function kept(name, otherwise) {
  try { return localStorage.getItem(`woundon.${name}`) ?? otherwise; } catch { return otherwise; }
}

/** Redraw a component when the store changes. */
export function useStore(store) {
  const [, draw] = useState(0);
  useEffect(() => {
    const listener = () => draw((n) => n + 1);
    store.listeners.add(listener);
    return () => store.listeners.delete(listener);
  }, [store]);
  return store.state;
}
