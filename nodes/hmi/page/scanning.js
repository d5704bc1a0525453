// Switch scanning: with one switch the mark goes on by itself, with two the first moves it on.
// First a group is chosen, then a button in it; STOP is in every round.

const ROUNDS = 2; // through a group without a choice, then back to the groups

export class Scanner {
  /**
   * `groups()` returns [{element, items: [button]}] as they are on the page now; `stop` is the STOP
   * button, and `singles()` are buttons that belong to no group. `pick(button, source)` presses a
   * button, `let(source)` lets it go, and `busy()` tells whether something moves, which the next
   * switch then ends by `halt()`.
   */
  constructor({ groups, stop, singles, pick, let: letGo, busy, halt, settings }) {
    Object.assign(this, { groups, stop, singles, pick, letGo, busy, halt, settings });
    this.timer = null;
    this.group = null; // the element whose buttons are scanned; null for the groups themselves
    this.marked = null;
    this.rounds = 0;
    addEventListener("keydown", (event) => this.#down(event), { capture: true });
    addEventListener("keyup", (event) => this.#up(event), { capture: true });
  }

  /** Begin or end, as the settings say. */
  restart() {
    this.group = null;
    this.#mark(null);
    this.#wait();
    if (this.settings().scan !== "off") this.#next();
  }

  /** With one switch: give the mark its time anew. */
  #wait() {
    clearInterval(this.timer);
    const { scan, scanSeconds } = this.settings();
    if (scan !== "one") return;
    this.timer = setInterval(() => !this.busy() && this.#next(), 1000 * scanSeconds);
  }

  /** What is scanned, as it is on the page now. */
  #round() {
    const groups = this.groups();
    if (this.group === null) {
      return [this.stop, ...this.singles(), ...groups.map(({ element }) => element)];
    }
    const { items } = groups.find(({ element }) => element === this.group) ?? { items: [] };
    return [...items, this.stop];
  }

  #next() {
    const round = this.#round();
    const at = round.indexOf(this.marked) + 1; // the first if what was marked is gone
    if (at < round.length) {
      this.#mark(round[at]);
      return;
    }
    this.rounds += 1;
    if (this.group !== null && this.rounds >= ROUNDS) {
      const left = this.group;
      this.group = null;
      this.rounds = 0;
      this.#mark(this.#round().includes(left) ? left : this.stop);
    } else this.#mark(round[0]);
  }

  #isSwitch({ code }) {
    const { scan } = this.settings();
    return (scan !== "off" && code === "Space") || (scan === "two" && code === "Enter");
  }

  #down(event) {
    if (!this.#isSwitch(event) || typing(event.target)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.repeat) return;
    this.rounds = 0;
    if (this.busy()) this.halt();
    else if (this.settings().scan === "two" && event.code === "Space") this.#next();
    else this.#choose(`switch ${event.code}`);
    this.#wait();
  }

  #up(event) {
    this.letGo(`switch ${event.code}`); // wherever the focus is now
    if (!this.#isSwitch(event) || typing(event.target)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this.#wait();
  }

  #choose(source) {
    const { marked } = this; // what the person sees, even if the page has changed since
    if (!this.#round().includes(marked)) {
      this.#next();
    } else if (marked.matches("button")) {
      this.pick(marked, source);
    } else {
      this.group = marked;
      this.#next();
    }
  }

  #mark(element) {
    this.marked?.classList.remove("marked");
    this.marked = element;
    if (element === null) return;
    element.classList.add("marked");
    if (!element.matches("button")) element.tabIndex = -1;
    element.focus();
  }
}

function typing(element) {
  return Boolean(element.closest?.("input, select, textarea"));
}
