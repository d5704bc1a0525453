// What each button means: the jog of a move in a mode, for a part, in a frame. Pure.

const HAND = {
  "forward": [1, 0, 0, 0, 0, 0],
  "back": [-1, 0, 0, 0, 0, 0],
  "left": [0, 1, 0, 0, 0, 0],
  "right": [0, -1, 0, 0, 0, 0],
  "up": [0, 0, 1, 0, 0, 0],
  "down": [0, 0, -1, 0, 0, 0],
  "roll-left": [0, 0, 0, -1, 0, 0],
  "roll-right": [0, 0, 0, 1, 0, 0],
  "pitch-up": [0, 0, 0, 0, -1, 0],
  "pitch-down": [0, 0, 0, 0, 1, 0],
  "yaw-left": [0, 0, 0, 0, 0, 1],
  "yaw-right": [0, 0, 0, 0, 0, -1],
};
const DIFFERENTIAL = {
  "forward": [1, 0],
  "back": [-1, 0],
  "left": [0, 1],
  "right": [0, -1],
  "yaw-left": [0, 1],
  "yaw-right": [0, -1],
};
const HOLONOMIC = {
  "forward": [1, 0, 0],
  "back": [-1, 0, 0],
  "left": [0, 0, 1],
  "right": [0, 0, -1],
  "yaw-left": [0, 1, 0],
  "yaw-right": [0, -1, 0],
};
const JOINT = { up: [1], down: [-1] };
const GRIP = { open: 1, close: -1 };

export const MOVES = [...Object.keys(HAND), ...Object.keys(GRIP)];
export const STEP = 0.02; // [m] of a bounded step
export const STEP_TURN = (5 * Math.PI) / 180; // [rad] of a bounded step that only turns
export const SPEEDS = { slow: 0.25, medium: 0.5, fast: 1 }; // shares of the limits

/** The part that the buttons move: the hand in shared mode, else what was chosen. */
export function partOf(mode, part) {
  return mode === "manual" ? part : "hand";
}

function table(part, base) {
  if (part === "hand") return HAND;
  if (part === "platform") return base === "holonomic" ? HOLONOMIC : DIFFERENTIAL;
  return JOINT;
}

/** Whether a button moves a part of this robot (`hello`). */
export function moves(move, part, hello) {
  return move in GRIP ? hello.gripper : move in table(part, hello.base);
}

/** Whether a move of a part only turns, so that its steps are angles. */
function turns(move, part, hello) {
  if (part.startsWith("joint/")) return !hello.joints[part.slice(6) - 1].slides;
  return table(part, hello.base) === DIFFERENTIAL
    ? table(part, hello.base)[move][1] !== 0
    : /^(roll|pitch|yaw)/.test(move);
}

/** Return the fields of the jog that brings the hand to a pose for as long as it is held. */
export function targetFields({ position, orientation }, view) {
  const target = orientation ? { position, orientation } : { position };
  return { mode: view.mode, part: "hand", frame: "robot", speeds: [SPEEDS[view.speed]], target };
}

/**
 * Return the fields of the jog of one move.
 *
 * `view` is what the person chose: mode, part, frame, camera heading [rad], speed, style.
 */
export function jogFields(move, view, hello) {
  const part = partOf(view.mode, view.part);
  const still = table(part, hello.base)[Object.keys(table(part, hello.base))[0]].map(() => 0);
  const share = SPEEDS[view.speed];
  const own = move in GRIP ? still : table(part, hello.base)[move].map((one) => one * share);
  const fields = { ...asFrame(view), part, speeds: own, grip: GRIP[move] ?? 0 };
  if (view.style === "step") fields.step = stepOf(move, part, hello);
  return fields;
}

/** Return the fields of the jog of a joystick: deflections -1 to 1 by move, the larger wins. */
export function stickFields(deflections, view, hello) {
  const part = partOf(view.mode, view.part);
  const rows = table(part, hello.base);
  const share = SPEEDS[view.speed];
  const speeds = Object.values(rows)[0].map(() => 0);
  let grip = 0;
  for (const [move, much] of Object.entries(deflections)) {
    if (move in GRIP) grip += hello.gripper ? GRIP[move] * much : 0;
    else rows[move]?.forEach((one, axis) => (speeds[axis] += one * much * share));
  }
  const inside = (one) => Math.max(-1, Math.min(1, one));
  return { ...asFrame(view), part, speeds: speeds.map(inside), grip: inside(grip) };
}

function asFrame({ mode, frame, heading }) {
  if (frame === "robot" || frame === "gripper") return { mode, frame };
  return { mode, frame: "mine", camera: heading };
}

function stepOf(move, part, hello) {
  if (move in GRIP) return STEP;
  return turns(move, part, hello) ? STEP_TURN : STEP;
}
