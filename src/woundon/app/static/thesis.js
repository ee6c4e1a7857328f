// Figures and tables of the thesis, computed by the server.
import * as api from "./api.js";
import { html, useEffect, useRef, useState } from "./html.js";
import { T } from "./texts.js";
import { digits } from "./units.js";

export function Thesis({ store }) {
  const known = store.catalogue.exhibits ?? [];
  const [name, setName] = useState(known[0]?.name ?? "");
  const [shown, setShown] = useState({});
  const abort = useRef(null);
  useEffect(() => () => abort.current?.abort(), []);
  const compute = async (which) => {
    setName(which);
    abort.current?.abort();
    abort.current = new AbortController();
    const { signal } = abort.current;
    setShown({ busy: true });
    try {
      const blob = await api.exhibit(which, signal);
      setShown({ url: URL.createObjectURL(blob), of: which });
    } catch (fault) {
      if (fault.name !== "AbortError") setShown({ fault: fault.message });
    }
  };
  const one = known.find((exhibit) => exhibit.name === name);
  return html`<section class="tab-card"><h2>${T.thesis.title}</h2>
    <div class="axis-row"><label class="stacked">${T.thesis.choose}<select id="exhibit" value=${name} onChange=${(event) => setName(event.target.value)}>
      ${known.map((exhibit) => html`<option value=${exhibit.name} selected=${exhibit.name === name}>${exhibit.label}: ${exhibit.title}</option>`)}</select></label>
      <div class="study-run"><button type="button" class="primary" disabled=${shown.busy} onClick=${() => compute(name)}>${T.thesis.compute}</button>
      <span class="quiet">${one?.seconds ? T.thesis.seconds(digits(one.seconds, 1)) : ""}</span></div></div>
    ${shown.busy && html`<p role="status">${T.thesis.wait} …</p>`}${shown.fault && html`<p class="fault" role="alert">${shown.fault}</p>`}
    ${shown.url && html`<img class="exhibit" src=${shown.url} alt=${known.find((exhibit) => exhibit.name === shown.of)?.title ?? ""} />`}
  </section>`;
}
