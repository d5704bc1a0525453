// What both views show at the edge: STOP, Release, the state of the stop, mode, driver, the age of
// the picture, and what was refused. Everybody may stop.
import { STALLED } from "./link.js";
import { Stop } from "./stop.js";
import { buildStopBar } from "./stopparts.js";
import { number, word } from "./words.js";

const SAID = 8000; // [ms] for which what was said stays to be read
const OLD = 0.5; // [s] from which on the age of a picture matters (Times.picture)

const find = (id) => document.getElementById(id);

/** Connects the bar to a link; `before()` is called before a STOP is sent. */
export class StopBar {
  constructor(link, { before = () => {} } = {}) {
    buildStopBar();
    this.link = link;
    this.hello = null;
    this.state = null;
    this.you = { driving: false, press: 0, picture: null };
    this.shown = { what: "none", ms: 0, seen: false };
    this.waits = new Map(); // requests without an answer yet, by id
    this.stop = new Stop({ link, show: (what, ms) => this.#stopIs(what, ms) });
    this.halt = () => {
      before();
      this.stop.press();
    };
    this.#connect();
  }

  #connect() {
    const stop = find("stop");
    stop.addEventListener("pointerdown", (event) => event.button === 0 && this.halt());
    stop.addEventListener("click", (event) => event.detail === 0 && this.halt()); // keys, readers
    find("release").onclick = () => {
      this.stop.forget();
      this.ask({ type: "release" });
    };
    find("take").onclick = () => {
      this.link.send({ type: "takeover" });
      this.say("take.waiting");
    };
    find("take-yes").onclick = () => this.link.send({ type: "yield", grant: true });
    find("take-no").onclick = () => this.link.send({ type: "yield", grant: false });
    const { link } = this;
    link.on("hello", (hello) => (this.hello = hello));
    link.on("state", (state) => this.#take(state));
    link.on("you", (you) => {
      this.you = you;
      this.#facts();
    });
    link.on("said", ({ key, params, urgent }) => this.say(key, params, urgent));
    link.on("done", (done) => this.#done(done));
    link.addEventListener("lost", () => {
      this.lost = true;
      this.waits.clear();
      this.#alert();
    });
    link.addEventListener("open", () => {
      if (this.lost) this.say("state.back");
      this.lost = false;
      this.#alert();
    });
    document.addEventListener("language", () => {
      this.#facts();
      this.#stopText();
      this.#alert();
    });
    setInterval(() => this.#age(), 200);
    const parts = [...document.querySelectorAll(".stopbar, .stoprow")]; // either may be sticky
    const measured = new ResizeObserver(() => {
      const height = Math.max(...parts.map((part) => part.getBoundingClientRect().height));
      document.documentElement.style.setProperty("--bar", `${Math.ceil(height)}px`);
    });
    for (const part of parts) measured.observe(part); // so that the focus stays above it
  }

  /** Send a request; what is refused is said. */
  ask(message, then = () => {}) {
    const id = this.link.ask(message);
    if (id === 0) this.say("move.offline", {}, true);
    else this.waits.set(id, then);
  }

  #done({ id, ok, key, params }) {
    const then = this.waits.get(id);
    this.waits.delete(id);
    if (!ok) this.say(key, params);
    else then?.();
  }

  /** Say something to be seen and, by a screen reader, heard. */
  say(key, params = {}, urgent = false) {
    const text = word(key, named(params));
    clearTimeout(this.forget);
    const place = find("said");
    place.textContent = text;
    place.classList.toggle("urgent", urgent);
    this.forget = setTimeout(() => this.hush(), SAID);
  }

  /** What was said last no longer matters. */
  hush() {
    clearTimeout(this.forget);
    find("said").textContent = "";
  }

  #take(state) {
    this.state = state;
    this.came = performance.now();
    const halted = state.gate?.halted ?? false;
    if (halted) this.shown.seen = true;
    else if (this.shown.seen && this.shown.what === "confirmed") this.#stopIs("none", 0);
    this.#facts();
    this.#stopText();
  }

  #stopIs(what, ms) {
    this.shown = { what, ms, seen: false };
    document.body.dataset.stop = what;
    this.#stopText();
    this.#alert();
  }

  #stopText() {
    const gate = this.state?.gate;
    const { what, ms } = this.shown;
    let text = "";
    if (what !== "none") text = word(`stop.${what}`, { ms });
    else if (gate?.halted) text = word("stop.held", { by: gate.by });
    else if (gate) text = word("stop.moving");
    put(find("stop-state"), text);
    document.body.dataset.halted = String(Boolean(gate?.halted));
    find("release").setAttribute("aria-disabled", String(!gate?.halted));
  }

  #facts() {
    const { state, you } = this;
    const gate = state?.gate;
    const mode = gate ? word("state.mode", { mode: word(`mode.${gate.mode}`) }) : word("state.nomode");
    let driver = "";
    if (you.driving) driver = word("state.you");
    else if (state && state.driver !== null) driver = word("state.other", { viewer: state.driver });
    else if (state) driver = word("state.nobody");
    document.body.dataset.mode = gate?.mode ?? "";
    put(find("status-mode"), mode);
    put(find("status-driver"), driver);
    put(find("viewers"), state ? word("state.viewers", { n: state.viewers }) : "");
    const other = Boolean(state) && state.driver !== null && !you.driving;
    find("take").hidden = !other;
    const asked = you.driving && state?.asking !== null && state?.asking !== undefined;
    find("asked").hidden = !asked;
  }

  /** How old the picture is [s]: as the server says, and since it came. */
  get age() {
    if (this.state === null) return Infinity;
    return (performance.now() - this.came) / 1000 + this.state.age;
  }

  /** Whether the picture is so old that nothing would move. */
  get old() {
    return this.age >= OLD;
  }

  #age() {
    const { age, old } = this;
    const known = Number.isFinite(age);
    const s = number(age, 1);
    put(find("age"), known ? word(old ? "state.old" : "state.age", { s }) : "");
    document.body.dataset.old = String(old);
    this.#alert();
  }

  #alert() {
    let text = "";
    if (this.shown.what === "unconfirmed") text = word("stop.unconfirmed");
    else if (this.lost) text = word("state.lost");
    else if (this.link.open && performance.now() - this.link.heard > 4 * STALLED) {
      text = word("state.lost");
    }
    put(find("alert"), text);
  }
}

/** Change a text only if it is another, so that a screen reader does not read it again. */
export function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** Words in place of the names of modes among the values of a text. */
function named(params) {
  const modes = ["rest", "automatic", "shared", "manual"];
  const entries = Object.entries(params).map(([name, value]) => {
    const isMode = ["mode", "wanted"].includes(name) && modes.includes(value);
    return [name, isMode ? word(`mode.${value}`) : value];
  });
  return Object.fromEntries(entries);
}
