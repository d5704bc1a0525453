// The operator's view: connects the parts of the page with each other and with the robot.
import { choices } from "./choices.js";
import { Arm } from "./arm.js";
import { MOVES, jogFields, jointOf, moves, stickFields, targetFields } from "./driving.js";
import { Pad } from "./gamepad.js";
import { holdButton, watchWindow } from "./holding.js";
import { Link } from "./link.js";
import { Picture } from "./picture.js";
import { Marker, Places, TO_MARKER, TO_PLACE } from "./places.js";
import { Presses } from "./press.js";
import { Scanner } from "./scanning.js";
import { Settings } from "./settings.js";
import { shortcuts } from "./shortcuts.js";
import { StopBar, put } from "./stopbar.js";
import { number, offerLanguages, word } from "./words.js";

const JOGS = 50; // [ms] from one jog to the next (Times.jog)
const MODES = ["rest", "automatic", "shared", "manual"];
const LIMITS = [50, 100, 150, 200, 250]; // [mm/s] largest speeds of the hand to choose from

const find = (id) => document.getElementById(id);
const buttons = [...document.querySelectorAll("[data-move]")];

const link = new Link();
const presses = new Presses({
  jog: (press) => {
    const message = { type: "jog", press: press.number, state: picture.painted, ...press.fields };
    if (link.flows && picture.painted > 0) link.send(message);
    else presses.end("press.link");
  },
  letGo: (press) => link.send({ type: "let_go", press }),
  changed: (press, why) => {
    for (const button of document.querySelectorAll("[data-move]")) {
      button.classList.toggle("held", press?.move === button.dataset.move);
    }
    if (press !== null) bar.hush();
    else if (why && why !== "press.released" && why !== "press.step") bar.say(why);
  },
});
const bar = new StopBar(link, { before: () => presses.end("press.halted") });
const picture = new Picture(link, { marked: (position) => marker.put(position, true) });
const settings = new Settings(find("settings-body"), (name) => chosen(name));
const chose = settings.settings;
let hello = null;
let joint = 1; // the one that was used last
let limitChoices = null;

const mode = () => bar.state?.gate?.mode ?? null;
const hand = () => bar.state?.hand?.position ?? null;
const hold = (button) => {
  holdButton(button, presses, press);
  button.addEventListener("click", ({ detail }) => detail > 0 && goTo(button.dataset.move));
};
const places = new Places({
  request: (message) => bar.ask(message),
  hold,
  before: () => isTarget(presses.held?.move ?? null) && presses.end("press.lost"),
});
const marker = new Marker({ moved: (position) => picture.mark(position), hand, hold });
const arm = new Arm({ hold });

// What the buttons do

/** Whether a move leads to a place or the marker. */
function isTarget(move) {
  return move !== null && (move === TO_MARKER || move.startsWith(TO_PLACE));
}

function targetOf(move) {
  if (move === TO_MARKER) return marker.position && { position: marker.position };
  return places.places[move.slice(TO_PLACE.length)];
}

/** Return what hinders a move, as words and values; null if nothing does. */
function hinders(move) {
  const gate = bar.state?.gate;
  if (!link.flows || hello === null) return ["move.offline", {}];
  if (!gate) return ["mode.none", {}];
  if (bar.old) return ["move.old", {}];
  if (picture.painted === 0) return ["move.unseen", {}];
  if (gate.halted) return ["move.halted", {}];
  if (isTarget(move)) {
    if (!targetOf(move)) return ["goal.none", {}];
    if (gate.mode === "automatic" && hello.tasks.length > 0) return ["refused.source", {}];
    return gate.mode === "shared" || gate.mode === "automatic" ? null : ["places.mode", {}];
  }
  if (gate.mode !== "shared" && gate.mode !== "manual") return ["move.rest", {}];
  if ((move === "open" || move === "close") && !hello.gripper) return ["move.gripper", {}];
  if (move !== null && !moves(move, gate.mode, joint, hello)) {
    return ["move.part", { button: word(`move.${move}`) }];
  }
  return null;
}

function view(style) {
  const heading = chose.frame === "seat" ? chose.seatHeading : picture.heading;
  return { mode: mode(), joint, frame: chose.frame, heading, speed: chose.speed, style };
}

function press(source, move) {
  if (presses.held === null) {
    const why = hinders(move);
    if (why !== null) {
      bar.say(...why);
      return;
    }
    if (isTarget(move) && mode() === "automatic") {
      if (!source.startsWith("pointer")) goTo(move); // a pointer's click follows
      return;
    }
  }
  const style = styleOf(source, move);
  if (presses.held === null) joint = jointOf(move) ?? joint;
  const fields = presses.held === null ? fieldsOf(move, style) : null;
  presses.down(source, move, style, fields, chose.seconds, performance.now());
}

/** How a press goes on. A click cannot be held, and a way to a place is no step. */
function styleOf(source, move) {
  const style = source === "click" && chose.style === "hold" ? "step" : chose.style;
  return isTarget(move) && style === "step" ? "click" : style;
}

function fieldsOf(move, style) {
  if (isTarget(move)) return targetFields(targetOf(move), view(style));
  return jogFields(move, view(style), hello);
}

/** In automatic mode: make a place or the marker the goal. */
function goTo(move) {
  if (!isTarget(move) || mode() !== "automatic" || hinders(move) !== null) return;
  if (move === TO_MARKER) bar.ask({ type: "goal", position: marker.position });
  else bar.ask({ type: "go", place: move.slice(TO_PLACE.length) });
}

for (const button of buttons) holdButton(button, presses, press);
setInterval(() => presses.tick(performance.now()), JOGS);
link.on("ended", ({ press: which, why }) => presses.ended(which, why));
link.addEventListener("lost", () => presses.end("press.link"));
setInterval(() => {
  if (presses.held !== null && !link.flows) presses.end("press.link");
}, JOGS);

// Joystick, switches, single keys

const pad = new Pad({
  drive: (deflections) => {
    const style = "hold";
    if (presses.held?.source === "pad") {
      presses.update("pad", stickFields(deflections, view(style), hello));
      return true;
    }
    const [move] = Object.keys(deflections);
    if (presses.held !== null || hinders(null) !== null) {
      const why = hinders(null);
      if (why) bar.say(...why);
      return false;
    }
    const fields = stickFields(deflections, view(style), hello);
    presses.down("pad", move, style, fields, chose.seconds, performance.now());
    return presses.held !== null;
  },
  release: () => presses.up("pad"),
  halt: () => bar.halt(),
  gone: () => presses.lose("pad", "press.pad"),
  seen: (name) => padText(name),
});
setInterval(() => pad.look(chose.pad === "on"), JOGS);

function padText(name) {
  if (chose.pad === "on") bar.say(name ? "pad.found" : "pad.none", { name });
}

const scanner = new Scanner({
  groups: () =>
    [...document.querySelectorAll("[data-scan]")]
      .map((element) => ({ element, items: [...element.querySelectorAll("button")].filter(usable) }))
      .filter(({ items }) => items.length > 0),
  stop: find("stop"),
  singles: () => ["release", "take", "take-yes", "take-no"].map(find).filter(usable),
  pick: (button, source) => {
    const { move } = button.dataset;
    if (move === undefined) button.click();
    else press(source, move);
  },
  let: (source) => presses.up(source),
  busy: () => presses.held !== null,
  halt: () => presses.end("press.released"),
  settings: () => chose,
});

function usable(button) {
  return button.checkVisibility() && button.getAttribute("aria-disabled") !== "true";
}

shortcuts({
  on: () => chose.keys === "on",
  press,
  up: (source) => presses.up(source),
  halt: () => bar.halt(),
});
watchWindow(presses); // after the single keys, which keep theirs to themselves

// What is shown

const modeChoices = choices(
  find("mode"),
  MODES.map((each) => ({ value: each, text: () => word(`mode.${each}`) })),
  (wanted) => {
    presses.end("press.mode");
    bar.ask({ type: "mode", mode: wanted });
  },
);

function showLimits() {
  const possible = LIMITS.filter((mm) => mm <= 1000 * hello.limits.speed + 1e-6);
  limitChoices = choices(
    find("limit"),
    possible.map((mm) => ({ value: mm, text: () => word("limit.value", { mm }) })),
    (mm) => bar.ask({ type: "limit", limit: mm / 1000 }),
    true,
  );
}

function modeText(shown) {
  if (!shown) return word("mode.none");
  const tasks = hello?.tasks.join(", ");
  if (shown === "automatic" && tasks) return word("mode.automatic.task", { tasks });
  return word(`mode.${shown}.text`);
}

/** What the buttons of the platform do in manual mode, and Up and Down. */
function partText() {
  if (mode() !== "manual" || !hello) return "";
  const platform = hello.base === "fixed" ? "" : `${word(`part.${hello.base}.text`)} `;
  return platform + (hello.joints.length > 0 ? word("part.joint.text", { n: joint }) : "");
}

/** Show what follows from mode, part and settings. */
function show() {
  const gate = bar.state?.gate ?? null;
  modeChoices.set(gate?.mode ?? null);
  limitChoices?.set(gate ? Math.round(1000 * gate.limit) : null);
  put(find("mode-text"), modeText(gate?.mode));
  const manual = gate?.mode === "manual";
  put(find("part-text"), partText());
  find("arm-pad").hidden = !manual || !hello?.joints.length;
  find("turn-pad").hidden = manual && hello?.base !== "holonomic";
  const why = hinders(null);
  const how = { s: number(chose.seconds), cm: 2, deg: 5 };
  put(find("move-text"), why ? word(...why) : word(`move.${chose.style}`, how));
  for (const button of document.querySelectorAll("[data-move]")) {
    button.setAttribute("aria-disabled", String(hinders(button.dataset.move) !== null));
  }
  find("setting-seat").hidden = chose.frame !== "seat";
  find("setting-seconds").hidden = chose.style !== "click";
  find("setting-scanSeconds").hidden = chose.scan !== "one";
}

function chosen(name) {
  presses.end("press.released");
  if (name === "seat" || name === "frame") {
    settings.put("seatHeading", (bar.state?.base?.[2] ?? 0) + (chose.seat * Math.PI) / 180);
  }
  if (name === "pad") padText(pad.name);
  if (name === "scan" || name === "scanSeconds") scanner.restart();
  show();
}

function names() {
  for (const button of buttons) button.textContent = word(`move.${button.dataset.move}`);
  if (hello) document.title = word("title.robot", { robot: hello.robot });
  show();
}

link.on("hello", (message) => {
  hello = message;
  offerLanguages(find("language"), hello.language);
  if (joint > hello.joints.length) joint = 1;
  arm.take(hello);
  showLimits();
  places.take(hello.places, hello.tasks);
  find("to-engineer").hidden = hello.role !== "engineer";
  find("gripper-pad").hidden = !hello.gripper;
  names();
});
link.on("state", show);
link.on("places", ({ places: all }) => places.take(all));
link.addEventListener("lost", show);
document.addEventListener("language", names);

// Help for the first time

function help(open) {
  find("help").hidden = !open;
  find("help-open").setAttribute("aria-expanded", String(open));
  if (!open) settings.put("helped", true);
}
find("help-open").onclick = () => help(find("help").hidden);
find("help-close").onclick = () => {
  help(false);
  find("help-open").focus();
};
help(!chose.helped);

offerLanguages(find("language"), "en");
if (buttons.length !== MOVES.length) throw new Error("a button is missing");
scanner.restart();
link.connect();
