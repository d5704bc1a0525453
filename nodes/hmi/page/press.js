// One press of one button at a time: who holds it, and all that ends it. No document, no socket,
// no clock: times are passed in [ms] and what is to be sent is handed out, so a test can drive it.

/** How a press goes on: `hold` while it is held, `step` a bounded way, `click` until the next. */
export const STYLES = ["hold", "step", "click"];

/**
 * The presses of this browser.
 *
 * `jog(press)` sends a press that is alive, `letGo(number)` its end; `changed(press, why)` shows
 * which is held now (or null) and the words' key of why the last one ended ("" if one began).
 */
export class Presses {
  constructor({ jog, letGo, changed }) {
    this.send = { jog, letGo };
    this.changed = changed;
    this.count = 0;
    this.held = null;
  }

  /**
   * A button went down. `source` tells pointers, keys, switches and joysticks apart; `fields` are
   * those of the jog, `seconds` is the limit of a click-click press.
   */
  down(source, move, style, fields, seconds, now) {
    if (this.held !== null) {
      const again = this.held.style === "click" || this.held.style === "step";
      this.end(again ? "press.released" : "press.second");
      return;
    }
    const until = style === "click" ? now + 1000 * seconds : Infinity;
    this.held = { number: ++this.count, source, move, style, fields, until };
    this.changed(this.held, "");
    this.send.jog(this.held);
  }

  /** What the joystick asks for has changed while it is held. */
  update(source, fields) {
    if (this.held?.source === source) this.held.fields = fields;
  }

  /** The button of this source went up: the end of a press that is held, and only of its own. */
  up(source) {
    if (this.held?.source === source && this.held.style === "hold") this.end("press.released");
  }

  /** The source left its button, lost it or is gone: the end of its press, whatever the style. */
  lose(source, why) {
    if (this.held?.source === source) this.end(why);
  }

  /** The server says that a press is over. */
  ended(number, why) {
    if (this.held?.number !== number) return;
    this.held = null;
    this.changed(null, why);
  }

  /** End whatever is held. */
  end(why) {
    if (this.held === null) return;
    const { number } = this.held;
    this.held = null;
    this.send.letGo(number);
    this.changed(null, why);
  }

  /** Send what is held again; call it each period of jogs. */
  tick(now) {
    if (this.held === null) return;
    if (now >= this.held.until) this.end("press.time");
    else this.send.jog(this.held);
  }
}
