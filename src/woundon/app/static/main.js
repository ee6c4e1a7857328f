// The page: header, form on the left, what the case says on the right.
import { keepAddress, restore } from "./address.js";
import * as api from "./api.js";
import { forgetColours } from "./chart.js";
import { Patterns } from "./drawing.js";
import { Menu } from "./exchange.js";
import { Find } from "./find.js";
import { Fit } from "./fit.js";
import { Form } from "./form.js";
import { html, render, useEffect, useLayoutEffect, useMemo } from "./html.js";
import { Differences, Numbers, Panels, Pending, Pins, Sections, Verdict } from "./results.js";
import { ROLLS, Store, TABS, useStore } from "./store.js";
import { Study } from "./study.js";
import { T } from "./texts.js";
import { Thesis } from "./thesis.js";
import { Winding } from "./winding.js";
import { Window } from "./window.js";

const tabsOf = ({ catalogue }) => TABS.filter((name) => name !== "thesis" || catalogue.exhibits?.length);

function Page({ store }) {
  const state = useStore(store);
  useLayoutEffect(() => {
    if (state.theme) document.documentElement.dataset.theme = state.theme;
    else delete document.documentElement.dataset.theme;
    forgetColours();
  }, [state.theme]);
  useEffect(() => {
    const keys = (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
      if (event.target.matches("textarea, dialog input")) return; // these have their own
      event.preventDefault();
      if (event.shiftKey) store.redo();
      else store.undo();
    };
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const repaint = () => { forgetColours(); store.set({ scheme: dark.matches }); };
    addEventListener("keydown", keys);
    dark.addEventListener("change", repaint);
    return () => { removeEventListener("keydown", keys); dark.removeEventListener("change", repaint); };
  }, [store]);
  const views = { case: Case, study: Study, fit: Fit, winding: Winding, window: Window, thesis: Thesis };
  // while a slider moves, the form does not wait for the answer, nor the answer for the form
  const form = useMemo(() => html`<${Form} store=${store} />`, [state.kind, state.tab, state.case, state.grade, state.faults, state.misread, state.system]);
  return html`<a class="skip" href="#results" onClick=${(event) => { event.preventDefault(); document.getElementById("results").focus(); }}>${T.skip}</a>
    <${Patterns} />
    <${Header} store=${store} />
    <div class=${`working${state.busy ? " busy" : ""}${state.rough ? " rough" : ""}`} aria-hidden="true"></div>
    <div class="split">
      <aside class="left">${state.tab !== "thesis" && form}</aside>
      <main class="right" id="results" tabindex="-1" aria-label=${T.results.name}>
        ${state.lost && html`<div class="notice" id="lost" role="alert">${state.lost}</div>`}
        ${state.notice && html`<div class="notice" id="notice" role="alert">${state.notice}</div>`}
        <div role="tabpanel" id=${`panel-${state.tab}`} aria-labelledby=${`tab-${state.tab}`} class="view"><${views[state.tab]} store=${store} /></div>
      </main>
    </div>
    <div class="says" role="status" aria-live="polite">${state.message}</div>`;
}

function Header({ store }) {
  const { state, catalogue } = store;
  const { tab } = state; // studies and fits are of any kind, figures of the thesis of none
  const kinds = catalogue.kinds.filter(({ name }) => (tab === "case" ? !ROLLS.includes(name) : ["winding", "window"].includes(tab) ? ROLLS.includes(name) : true));
  return html`<header class="top">
    <h1><img src="/static/icon.svg" width="26" height="26" alt="" /><span>${T.title}</span></h1>
    <${Tabs} store=${store} />
    <div class="tools">
      ${tab !== "thesis" && html`<label><span class="hidden">${T.header.kind}</span>
        <select class="kind" value=${state.kind} onChange=${(event) => store.goTo(event.target.value)}>
          ${kinds.map((kind) => html`<option value=${kind.name} selected=${kind.name === state.kind}>${T.kinds[kind.name] ?? kind.title}</option>`)}</select></label>`}
      <button type="button" onClick=${() => store.undo()} disabled=${!state.past.length} title=${`${T.header.undo} (Ctrl+Z)`} aria-label=${T.header.undo}>↶</button>
      <button type="button" onClick=${() => store.redo()} disabled=${!state.future.length} title=${`${T.header.redo} (Ctrl+Shift+Z)`} aria-label=${T.header.redo}>↷</button>
      <div class="segmented" role="group" aria-label=${T.header.units}>${Object.keys(catalogue.systems).map((name) => html`<button type="button"
        aria-pressed=${state.system === name} onClick=${() => store.prefer("system", name)}>${name}</button>`)}</div>
      <${Menu} store=${store} />
    </div>
  </header>`;
}

function Tabs({ store }) {
  const { tab } = store.state;
  const tabs = tabsOf(store);
  const keys = (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const next = tabs[(tabs.indexOf(tab) + step + tabs.length) % tabs.length];
    store.show(next);
    document.getElementById(`tab-${next}`).focus();
  };
  return html`<div class="tabs" role="tablist" aria-label=${T.tabs.name} onKeyDown=${keys}>${tabs.map((name) => html`<button type="button" role="tab"
    id=${`tab-${name}`} aria-selected=${tab === name} aria-controls=${`panel-${name}`} tabindex=${tab === name ? 0 : -1} onClick=${() => store.show(name)}>${T.tabs[name]}</button>`)}</div>`;
}

function Case({ store }) {
  const { kind, result, solved, problem, faults, misread, extras, pins, tables, system, theme, scheme } = store.state;
  const stale = Object.keys(extras).filter((name) => store.extra(name).stale).join();
  return useMemo(() => {
    if (!result || result.kind !== kind) return html`<${Pending} store=${store} />`;
    return html`<${Verdict} store=${store} />
      <${Numbers} store=${store} />
      <${Find} store=${store} />
      <${Pins} store=${store} />
      <${Panels} store=${store} />
      <p class="quiet hint">${T.panels.hint}</p>
      <${Differences} store=${store} />
      <${Sections} store=${store} />`;
  }, [kind, result, solved, problem, faults, misread, extras, stale, pins, tables, system, theme, scheme]);
}

async function begin() {
  const place = document.getElementById("page");
  render(html`<p class="loading">${T.loading} …</p>`, place);
  try {
    const store = new Store(await api.catalogue());
    if (!await restore(store)) store.solve();
    document.title = `${T.title}: ${T.about}`;
    render(html`<${Page} store=${store} />`, place);
    keepAddress(store);
  } catch (fault) {
    render(html`<p class="loading" role="alert">${T.failed}: ${fault.message}</p>`, place);
    throw fault;
  }
}

begin();
