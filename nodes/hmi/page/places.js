// Goals: saved places and tasks as one button each, and the marker by dragging, numbers or nudges.
import { number, word } from "./words.js";

const NUDGE = 0.02; // [m]
const FAR = 50; // [m] that a marker may be away: more is a slip of the keys

const find = (id) => document.getElementById(id);

/** The names of the moves to a saved place, and to the marker. */
export const TO_PLACE = "place ";
export const TO_MARKER = "marker";

/**
 * The buttons of places and tasks. `request(message)` sends one, `hold(button)` connects one that
 * moves the hand while it is held, and `before()` is called before buttons are replaced.
 */
export class Places {
  constructor({ request, hold, before }) {
    Object.assign(this, { request, hold, before });
    this.places = {};
    this.tasks = [];
    document.addEventListener("language", () => this.#fill());
    find("place-form").onsubmit = (event) => {
      event.preventDefault();
      const place = find("place-name").value.trim();
      if (place) request({ type: "save", place });
      find("place-name").value = "";
    };
  }

  take(places, tasks = this.tasks) {
    this.places = places;
    this.tasks = tasks;
    this.#fill();
  }

  #fill() {
    this.before();
    const names = Object.keys(this.places);
    const goes = names.map((place) => {
      const button = made(word("places.go", { place }));
      button.dataset.move = TO_PLACE + place;
      this.hold(button);
      return button;
    });
    const start = (task) => () => this.request({ type: "task", task });
    const tasks = this.tasks.map((task) => made(word("places.task", { task }), start(task)));
    find("places").replaceChildren(...goes, ...tasks);
    if (goes.length + tasks.length === 0) find("places").textContent = word("places.none");
    const forget = (place) => () => this.request({ type: "forget", place });
    find("forget").replaceChildren(
      ...names.map((place) => made(word("places.forget", { place }), forget(place))),
    );
    find("forget-row").hidden = names.length === 0;
  }
}

/** The marker's numbers and nudges. `moved(position)` shows it, null hides it. */
export class Marker {
  constructor({ moved, hand, hold }) {
    this.moved = moved;
    this.position = null;
    this.inputs = ["x", "y", "z"].map((axis, i) => this.#row(axis, i));
    find("goal-here").onclick = () => hand() && this.put(hand());
    find("goal-go").dataset.move = TO_MARKER;
    hold(find("goal-go"));
    this.details = find("goal-part");
    // at the click, for "toggle" comes later, and may find a number that is being typed
    this.details.querySelector("summary").onclick = () => {
      if (this.position === null && hand()) this.put(hand());
    };
    this.details.ontoggle = () => moved(this.details.open ? this.position : null);
  }

  #row(axis, i) {
    const row = document.createElement("div");
    row.className = "nudge";
    row.setAttribute("role", "group");
    const label = document.createElement("label");
    label.dataset.word = `goal.${axis}`;
    const input = document.createElement("input");
    input.id = `goal-${axis}`;
    label.htmlFor = input.id;
    input.inputMode = "decimal";
    input.autocomplete = "off";
    input.onchange = () => {
      const value = Number(input.value.replace(",", "."));
      const sound = input.value.trim() !== "" && Math.abs(value) <= FAR;
      input.setAttribute("aria-invalid", String(!sound));
      if (sound) this.#set(i, value);
    };
    const less = made("−", () => this.#by(i, -NUDGE));
    const more = made("+", () => this.#by(i, NUDGE));
    const name = () => {
      less.setAttribute("aria-label", word("goal.less", { axis: word(`goal.${axis}`) }));
      more.setAttribute("aria-label", word("goal.more", { axis: word(`goal.${axis}`) }));
      if (this.position) this.put(this.position);
    };
    document.addEventListener("language", name);
    row.append(label, less, input, more);
    find("goal").append(row);
    return input;
  }

  #by(i, much) {
    if (this.position) this.#set(i, this.position[i] + much);
  }

  #set(i, value) {
    this.put((this.position ?? [0, 0, 0]).map((one, axis) => (axis === i ? value : one)));
  }

  /** Put the marker there; `dragged` if the picture shows it already. */
  put(position, dragged = false) {
    this.position = position.map((one) => Math.round(one * 1000) / 1000);
    this.inputs.forEach((input, i) => {
      input.value = number(this.position[i], 3).replace("\u2212", "-");
      input.setAttribute("aria-invalid", "false");
    });
    if (!dragged && this.details?.open) this.moved(this.position);
  }
}

function made(text, click) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = text;
  if (click) button.onclick = click;
  return button;
}
