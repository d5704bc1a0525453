// STOP: sent, confirmed by the robot after N ms, or NOT CONFIRMED. Idempotent, never a toggle.

const REPEAT = 250; // [ms] until an unanswered STOP is sent again

/** The state of the last STOP. `show(state, ms)` with sent, confirmed or unconfirmed. */
export class Stop {
  /** `confirm` [ms] is the time in which the robot has to confirm. */
  constructor({ link, show, confirm = 500 }) {
    this.link = link;
    this.show = show;
    this.confirm = confirm;
    this.waiting = null;
    link.on("halted", (message) => this.#answer(message));
    link.addEventListener("open", () => this.#send());
    link.addEventListener("lost", () => this.waiting && this.#fail());
  }

  press() {
    if (this.waiting !== null) clearTimeout(this.waiting.deadline);
    clearInterval(this.again);
    const id = this.link.next++;
    const deadline = setTimeout(() => this.#fail(), this.confirm);
    this.waiting = { id, since: performance.now(), deadline };
    this.again = setInterval(() => this.#send(), REPEAT);
    this.show("sent", 0);
    if (!this.#send()) this.#fail();
  }

  /** The person has released: an unanswered STOP is no longer sent. */
  forget() {
    if (this.waiting === null) return;
    clearTimeout(this.waiting.deadline);
    clearInterval(this.again);
    this.waiting = null;
    this.show("none", 0);
  }

  #send() {
    return this.waiting !== null && this.link.send({ type: "halt", id: this.waiting.id });
  }

  #answer({ id, confirmed }) {
    if (this.waiting?.id !== id) return;
    if (!confirmed) {
      this.#fail();
      return;
    }
    clearTimeout(this.waiting.deadline);
    clearInterval(this.again);
    const ms = Math.round(performance.now() - this.waiting.since);
    this.waiting = null;
    this.show("confirmed", ms);
  }

  /** Say so; it is sent on all the same until the robot answers. */
  #fail() {
    clearTimeout(this.waiting.deadline);
    this.show("unconfirmed", 0);
  }
}
