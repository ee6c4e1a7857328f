// Requests to the server; a rejected request throws a Problem.
import { T } from "./texts.js";

const session = Array.from(crypto.getRandomValues(new Uint8Array(12)), (b) => b.toString(16).padStart(2, "0")).join("");

export class Problem extends Error {
  constructor(details, status) {
    super(details.detail || details.title || `error ${status}`);
    this.status = status;
    this.errors = details.errors ?? [];
    this.superseded = String(details.type ?? "").endsWith("superseded");
  }
}

/** Called when the server does not respond, or rejects the token of the page. */
export const connection = { lost: () => {} };

function unreachable() {
  connection.lost();
  return new Problem({ detail: T.lost.interrupted }, 0);
}

async function asked(path, body, signal) {
  let answer;
  try {
    answer = await fetch(path, {
      method: body === undefined ? "GET" : "POST",
      headers: { "X-Session": session, ...(body === undefined ? {} : { "Content-Type": "application/json" }) },
      body: body === undefined ? undefined : JSON.stringify(body),
      signal,
    });
  } catch (fault) {
    if (fault.name === "AbortError") throw fault;
    throw unreachable();
  }
  if (answer.ok) return answer;
  if (answer.status === 401) connection.lost();
  const details = await answer.json().catch(() => null); // a server that stops, and a proxy without one, write no JSON
  throw details ? new Problem(details, answer.status) : unreachable();
}

/** Read the body of an answer as "json", "text" or "blob"; it may break off, as when the server ends. */
async function read(as, ...call) {
  const answer = await asked(...call);
  return answer[as]().catch((fault) => { throw fault.name === "AbortError" ? fault : unreachable(); });
}

const json = (...call) => read("json", ...call);
const text = (...call) => read("text", ...call);
const query = (options) => {
  const fields = new URLSearchParams(Object.entries(options).filter(([, value]) => value != null && value !== false));
  return fields.size ? `?${fields}` : "";
};

export const catalogue = () => json("/api/catalogue");
export const solve = (tables, options, signal) => json(`/api/solve${query({ drawn: true, ...options })}`, tables, signal);
export const curve = (tables, options, signal) => json(`/api/curve${query(options)}`, tables, signal);
export const sensitivities = (tables, signal) => json("/api/sensitivities", tables, signal);
export const design = (tables, pressure, signal) => json("/api/design", { case: tables, pressure }, signal);
export const find = (body, signal) => json("/api/find", body, signal);
export const withGrade = (tables, grade) => json("/api/grade", { case: tables, grade });
export const readCase = (toml) => json("/api/case/read", { toml });
export const writeCase = (tables) => text("/api/case/write", tables);
export const python = (tables) => text("/api/python", tables);
export const file = (format, body) => read("blob", `/api/file${query({ format })}`, body);
export const figure = (format, body) => read("blob", `/api/figure${query({ format })}`, body);
export const report = (body) => read("blob", "/api/report", body);
export const exhibit = (name, signal) => read("blob", `/api/thesis/${encodeURIComponent(name)}`, undefined, signal);

/** A stream of events, one line each; abort the signal to cancel. */
async function stream(path, body, handle, signal) {
  const answer = await asked(path, body, signal);
  const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (;;) {
    const { value, done } = await reader.read().catch((fault) => { throw fault.name === "AbortError" ? fault : unreachable(); });
    if (done) break;
    const lines = (rest + value).split("\n");
    rest = lines.pop();
    for (const event of lines.filter(Boolean).map((line) => JSON.parse(line))) {
      if (event.event === "failed") throw new Problem(event.problem, event.problem.status);
      handle(event);
    }
  }
}

export const sweep = (study, handle, signal) => stream("/api/sweep", study, handle, signal);
export const fit = (body, handle, signal) => stream("/api/fit", body, handle, signal);
export const operatingWindow = (body, handle, signal) => stream("/api/window", body, handle, signal);

/** Runs the newest request alone: while one is under way only the last that came waits. */
export class Newest {
  constructor(patience = 5000) {
    this.patience = patience; // [ms] then a newer one goes first
    this.waiting = null;
    this.running = null;
  }

  ask(work) {
    this.waiting = work;
    if (!this.running) this.next();
    else if (performance.now() - this.running.since > this.patience) this.running.abort.abort();
  }

  drop() {
    this.waiting = null;
    this.running?.abort.abort();
  }

  async next() {
    while (this.waiting) {
      const work = this.waiting;
      const abort = new AbortController();
      this.waiting = null;
      this.running = { since: performance.now(), abort };
      const late = setTimeout(() => { if (this.waiting) abort.abort(); }, this.patience);
      try {
        await work(abort.signal);
      } catch (fault) {
        if (fault.name !== "AbortError") throw fault;
      } finally {
        clearTimeout(late);
        this.running = null;
      }
    }
  }
}
