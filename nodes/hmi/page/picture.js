// What a person sees of the robot: the 3D scene where there is WebGL, and always the same in words.
// It says which state has been painted: only after drawing, or, without WebGL, after the words.
import { put } from "./stopbar.js";
import { number, word } from "./words.js";

const WORDS = 500; // [ms] from one text to the next
const TURN = Math.PI / 8;
const ZOOM = 1.25;
const NEAREST = 3; // things that are named
const PAUSE = 200; // [ms] after a frame at most: an old picture ends what is held

const find = (id) => document.getElementById(id);

export class Picture {
  /** `marked(position)` is called when the goal marker is dragged. */
  constructor(link, { marked }) {
    this.link = link;
    this.painted = 0; // number of the state that was painted last
    this.state = null;
    this.hello = null;
    this.marked = marked;
    this.marker = null;
    this.written = -Infinity;
    link.on("hello", (hello) => {
      this.hello = hello;
      this.state = null;
      this.painted = 0;
      this.scene?.build(hello);
    });
    link.on("state", (state) => {
      this.state = state;
      this.scene?.show(state);
    });
    this.#buttons();
    this.#load();
    this.#ask();
  }

  async #load() {
    try {
      const { Scene } = await import("./scene.js");
      const hooks = { lost: (gone) => this.#none(gone), moved: (position) => this.marked(position) };
      this.scene = new Scene(find("scene"), hooks);
    } catch {
      this.#none(true);
      return;
    }
    this.#none(false);
    if (this.hello) this.scene.build(this.hello);
    if (this.state) this.scene.show(this.state);
    this.mark(this.marker);
  }

  #none(gone) {
    find("no-picture").hidden = !gone;
    find("view").hidden = gone;
    document.body.dataset.picture = gone ? "words" : "drawn";
  }

  #buttons() {
    for (const from of ["behind", "side", "above"]) {
      find(`view-${from}`).onclick = () => this.scene?.view(from);
    }
    find("view-left").onclick = () => this.scene?.move(-TURN, 1);
    find("view-right").onclick = () => this.scene?.move(TURN, 1);
    find("view-closer").onclick = () => this.scene?.move(0, 1 / ZOOM);
    find("view-farther").onclick = () => this.scene?.move(0, ZOOM);
  }

  /**
   * Draw frames, with a pause after each that is as long as it kept this thread: so however slow
   * drawing is, half of the time is left to send what is held, before the robot stops for want of it.
   */
  #ask() {
    requestAnimationFrame((now) => {
      const begun = performance.now();
      const pause = () => setTimeout(() => this.#ask(), Math.min(performance.now() - begun, PAUSE));
      setTimeout(pause); // it waits until the frame is on its way
      this.#turn(now);
    });
  }

  #turn(now) {
    this.scene?.paint();
    if (this.state === null) {
      put(find("picture-text"), word("picture.wait"));
      return;
    }
    const drawn = this.scene && !this.scene.gone;
    if (!drawn || now - this.written >= WORDS) {
      this.written = now;
      put(find("picture-text"), this.#words());
    }
    if (this.state.number === this.painted) return;
    this.painted = this.state.number;
    if (this.link.flows) this.link.send({ type: "painted", state: this.painted });
  }

  /** Heading of "forward" as in the picture [rad]; without a picture that of the robot. */
  get heading() {
    if (this.scene && !this.scene.gone) return this.scene.cameraHeading;
    return this.state?.base?.[2] ?? 0;
  }

  /** Show the goal marker at a position, or hide it. */
  mark(position) {
    this.marker = position;
    this.scene?.mark(position);
  }

  #words() {
    const { hand, base, error, things } = this.state;
    if (hand === null) return word("picture.unknown");
    const [x, y, heading] = base ?? [0, 0, 0];
    const [dx, dy] = [hand.position[0] - x, hand.position[1] - y];
    const ahead = Math.cos(heading) * dx + Math.sin(heading) * dy;
    const left = Math.cos(heading) * dy - Math.sin(heading) * dx;
    const way = (value, plus, minus) =>
      word(`picture.${value >= 0 ? plus : minus}`, { d: number(Math.abs(value), 2) });
    const forward = way(ahead, "ahead", "behind");
    const side = way(left, "left", "right");
    const text = [word("picture.hand", { forward, side, z: number(hand.position[2], 2) })];
    if (error !== null) text.push(word("picture.error", { mm: number(1000 * error) }));
    if (things.length > 0) text.push(word("picture.things", { list: nearest(hand, things) }));
    return text.join(" ");
  }
}

/** Return the names of the things whose middles are nearest to the hand, with how far they are. */
function nearest({ position }, things) {
  const far = ({ name, pose }) => [Math.hypot(...pose.position.map((x, i) => x - position[i])), name];
  const sorted = things.map(far).sort(([one], [other]) => one - other);
  return sorted.slice(0, NEAREST).map(([d, name]) => `${name} ${number(d, 2)} m`).join(", ");
}
