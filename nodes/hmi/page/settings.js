// What the person chose, kept in the browser, and the form to choose it.
import { choices } from "./choices.js";
import { number, word } from "./words.js";

const KEPT = "settings";
const OPTIONS = {
  style: ["hold", "step", "click"],
  seconds: [1, 2, 3, 5, 10],
  speed: ["slow", "medium", "fast"],
  frame: ["picture", "seat", "robot", "gripper"],
  seat: [0, 90, 180, 270],
  scan: ["off", "one", "two"],
  scanSeconds: [0.8, 1.2, 1.8, 2.5, 4],
  pad: ["off", "on"],
  keys: ["off", "on"],
};
const FIRST = {
  style: "hold",
  seconds: 3,
  speed: "medium",
  frame: "picture",
  seat: 0,
  scan: "off",
  scanSeconds: 1.8,
  pad: "off",
  keys: "off",
};
const TITLES = {
  style: "settings.style",
  seconds: "settings.seconds",
  speed: "settings.speed",
  frame: "settings.frame",
  seat: "settings.seat",
  scan: "settings.scan",
  scanSeconds: "settings.scantime",
  pad: "settings.pad",
  keys: "settings.keys",
};
const TEXTS = { scan: "scan.text", pad: "pad.text", keys: "keys.text" };

/** Return what was chosen before, and what is left of it that is still a choice. */
export function kept() {
  let found = {};
  try {
    found = JSON.parse(localStorage.getItem(KEPT) ?? "{}") ?? {};
  } catch {
    // unreadable, or a browser that keeps nothing
  }
  const sound = Object.entries(OPTIONS).filter(([name, all]) => all.includes(found[name]));
  const settings = { ...FIRST, ...Object.fromEntries(sound.map(([name]) => [name, found[name]])) };
  settings.seatHeading = Number.isFinite(found.seatHeading) ? found.seatHeading : 0;
  settings.helped = found.helped === true;
  return settings;
}

function keep(settings) {
  try {
    localStorage.setItem(KEPT, JSON.stringify(settings));
  } catch {
    // then it is chosen again next time
  }
}

/** The form; `changed(name)` is called after each choice, and `settings` is what is chosen now. */
export class Settings {
  constructor(body, changed) {
    this.settings = kept();
    this.groups = {};
    for (const name of Object.keys(OPTIONS)) this.#row(body, name, changed);
  }

  #row(body, name, changed) {
    const row = document.createElement("div");
    row.className = "setting";
    row.id = `setting-${name}`;
    const title = document.createElement("h3");
    title.id = `setting-${name}-title`;
    title.dataset.word = TITLES[name];
    const group = document.createElement("div");
    group.className = "tiles";
    group.setAttribute("aria-labelledby", title.id);
    row.append(title);
    if (TEXTS[name]) {
      const text = document.createElement("p");
      text.id = `setting-${name}-text`;
      text.className = "small";
      text.dataset.word = TEXTS[name];
      group.setAttribute("aria-describedby", text.id);
      row.append(text);
    }
    row.append(group);
    body.append(row);
    const options = OPTIONS[name].map((value) => ({ value, text: () => shown(name, value) }));
    this.groups[name] = choices(group, options, (value) => {
      this.put(name, value);
      changed(name);
    }, true);
    this.groups[name].set(this.settings[name]);
  }

  /** Choose a value. */
  put(name, value) {
    this.settings[name] = value;
    this.groups[name]?.set(value);
    keep(this.settings);
  }
}

function shown(name, value) {
  if (name === "seconds") return word("seconds", { s: number(value) });
  if (name === "scanSeconds") return word("seconds", { s: number(value, 1) });
  if (name === "seat") return word(`seat.${value}`);
  if (name === "pad" || name === "keys") return word(`choice.${value}`);
  return word(`${name}.${value}`);
}
