// The engineer's view: processes, faults, plots, and the record of what happened.
import { Link } from "./link.js";
import { Plot } from "./plots.js";
import { StopBar, put } from "./stopbar.js";
import { number, offerLanguages, word } from "./words.js";

const KEPT = 500; // lines of the record
const DEGREES = 180 / Math.PI;

const find = (id) => document.getElementById(id);
const link = new Link();
const bar = new StopBar(link);
const plots = {
  error: new Plot(find("plots"), "plots.error"),
  joints: new Plot(find("plots"), "plots.joints"),
  answers: new Plot(find("plots"), "plots.answers"),
};
let hello = null;
let table = { rows: [], refused: {} };
let chosen = null;
const answering = new Set(); // roles that have ever answered the plant, each a line of the plot
let happened = [];

link.on("hello", (message) => {
  hello = message;
  offerLanguages(find("language"), hello.language);
  find("engineer-only").hidden = hello.role === "engineer";
  find("faults").replaceChildren(...hello.faults.map((fault) => new Option(fault, fault)));
  chosen ??= hello.processes[0] ?? null;
  offerPartition(hello.rehearsal);
  happened = [...hello.happened];
  record();
  show();
});

// Processes

link.on("processes", (message) => {
  table = message;
  show();
  const answers = new Map(table.rows.map(({ role, answer }) => [role, answer]));
  for (const [role, answer] of answers) if (answer !== null) answering.add(role);
  if (bar.state && answering.size > 0) {
    const times = [...answering].map((role) => answers.get(role) ?? null);
    const names = [...answering].map((role) => () => role);
    plots.answers.add(bar.state.t, names, times.map((one) => one && 1000 * one));
  }
});

function show() {
  const body = find("processes");
  const old = new Map([...body.children].map((row) => [row.dataset.role, row]));
  body.append(...table.rows.map((process) => filled(old.get(process.role) ?? row(process), process)));
  for (const [role, element] of old) {
    if (!table.rows.some((process) => process.role === role)) element.remove();
  }
  put(find("act-title"), word("act.title", { role: chosen ?? "" }));
  const refused = Object.entries(table.refused).map(([why, count]) => `${why} ${count}`);
  const list = refused.join(", ") || word("processes.nothing");
  put(find("page-refused"), word("processes.page", { list }));
  const limit = hello?.rehearsal?.longest ?? 0;
  put(find("partition-text"), word("partition.text", { s: number(limit, 1) }));
}

function row({ role }) {
  const line = document.createElement("tr");
  line.dataset.role = role;
  const button = document.createElement("button");
  button.type = "button";
  button.onclick = () => {
    chosen = role;
    show();
  };
  button.textContent = role;
  const cell = document.createElement("td");
  cell.append(button);
  line.append(cell);
  for (const kind of ["state", "count", "count", "count", "count", "says", "host", "count"]) {
    const next = document.createElement("td");
    next.className = kind;
    line.append(next);
  }
  return line;
}

const STATES = {
  runs: "process.runs",
  silent: "process.state.silent",
  gone: "process.state.gone",
  none: "process.none",
};

function filled(line, { role, state, says, host, pid, rate, answer, restarts, refused }) {
  line.dataset.state = state;
  line.firstChild.firstChild.setAttribute("aria-pressed", String(role === chosen));
  const texts = [
    word(STATES[state]),
    rate === null ? "–" : word("processes.hertz", { n: number(rate, 1) }),
    answer === null ? "–" : word("processes.ms", { n: number(1000 * answer, 1) }),
    number(restarts),
    number(refused),
    says,
    host,
    pid === null ? "–" : String(pid),
  ];
  texts.forEach((text, i) => put(line.children[i + 1], text));
  return line;
}

for (const button of document.querySelectorAll("[data-act]")) {
  button.onclick = () => chosen && bar.ask({ type: "act", what: button.dataset.act, role: chosen });
}
find("fault-form").onsubmit = (event) => {
  event.preventDefault();
  bar.ask({ type: "fault", fault: find("fault").value.trim() });
};

// Partitions, in a rehearsal

const host = find("partition-host");
const seconds = find("partition-seconds");

function offerPartition(rehearsal) {
  find("partition").hidden = rehearsal === null;
  if (rehearsal === null) return;
  const before = host.value; // of a connection that was lost
  host.replaceChildren(...rehearsal.hosts.map((name) => new Option(name)));
  if (rehearsal.hosts.includes(before)) host.value = before;
  [seconds.min, seconds.max] = [rehearsal.shortest, rehearsal.longest];
}

find("partition-form").onsubmit = (event) => {
  event.preventDefault();
  const cut = { host: host.value, seconds: seconds.valueAsNumber };
  const said = { host: cut.host, s: cut.seconds };
  bar.ask({ type: "partition", ...cut }, () => bar.say("partition.done", said));
};

// Plots

link.on("state", ({ number: n, t, q, error }) => {
  plots.error.add(t, [() => word("plots.error")], [error === null ? null : 1000 * error]);
  if (hello !== null && q.length > 0) {
    const names = q.map((_, i) => () => word("plots.joint", { n: i + 1 }));
    const values = q.map((one, i) => one && one * (hello.joints[i]?.slides ? 1000 : DEGREES));
    plots.joints.add(t, names, values);
  }
  requestAnimationFrame(() => link.flows && link.send({ type: "painted", state: n }));
});

// What happened

link.on("happened", ({ what }) => {
  happened.push(what);
  happened = happened.slice(-KEPT);
  record();
});

function record() {
  const lines = happened.toReversed().map(({ t, key, params }) => {
    const line = document.createElement("li");
    const time = document.createElement("time");
    time.textContent = word("seconds", { s: number(t, 1) });
    line.append(time, ` ${word(key, params)}`);
    return line;
  });
  find("record").replaceChildren(...lines);
  if (lines.length === 0) {
    const line = document.createElement("li");
    line.textContent = word("record.empty");
    find("record").append(line);
  }
}

document.addEventListener("language", () => {
  document.title = word("engineer.title");
  show();
  record();
});
offerLanguages(find("language"), "en");
link.connect();
