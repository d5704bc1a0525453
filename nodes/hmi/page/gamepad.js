// A joystick or gamepad (the browser's standard mapping). Its deflection is the hold.

const DEAD = 0.25; // of an axis at rest: worn sticks do not come back to 0
const STOP_BUTTON = 1;
const AXES = [
  // axis, move below 0, move above 0
  [0, "left", "right"],
  [1, "forward", "back"],
  [2, "yaw-left", "yaw-right"],
  [3, "up", "down"],
];
const BUTTONS = { 4: "close", 5: "open" };

/** Return what a gamepad asks for: { deflections by move, stop }. */
export function readPad({ axes, buttons }) {
  const deflections = {};
  for (const [axis, below, above] of AXES) {
    const value = axes[axis] ?? 0;
    const much = (Math.abs(value) - DEAD) / (1 - DEAD);
    if (much > 0) deflections[value < 0 ? below : above] = Math.min(much, 1);
  }
  for (const [index, move] of Object.entries(BUTTONS)) {
    if (buttons[index]?.pressed) deflections[move] = 1;
  }
  return { deflections, stop: Boolean(buttons[STOP_BUTTON]?.pressed) };
}

/**
 * Looks at the first gamepad each turn. `drive(deflections)` begins or goes on with its press and
 * tells whether it lives, `release()` ends it; `gone()` is called when another or none is there, and
 * `seen(name)` after that.
 */
export class Pad {
  constructor({ drive, release, halt, gone, seen }) {
    this.take = { drive, release, halt, gone, seen };
    this.ready = false; // only after its sticks were let go once: no motion without a new press
    this.stopped = false;
    this.name = null;
  }

  /** Look at it now; `on` is whether the person has switched it on. */
  look(on) {
    const pad = on ? [...(navigator.getGamepads?.() ?? [])].find((one) => one?.connected) : null;
    const name = pad?.id ?? null;
    if (name !== this.name) {
      this.name = name;
      this.ready = false;
      this.take.gone();
      this.take.seen(name);
    }
    if (!pad) return;
    const { deflections, stop } = readPad(pad);
    if (stop && !this.stopped) this.take.halt();
    this.stopped = stop;
    const still = Object.keys(deflections).length === 0;
    if (still) {
      this.ready = true;
      this.take.release();
    } else if (this.ready && !this.take.drive(deflections)) {
      this.ready = false; // its press has ended: let go first
    }
  }
}
