// What each button means: the jog of a move in a mode, in a frame. Pure.

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
const OWN = /^(joint\/\d+)([+-])$/; // a button of one joint alone
const GRIP = { open: 1, close: -1 };

export const MOVES = [...Object.keys(HAND), ...Object.keys(GRIP)];
export const STEP = 0.02; // [m] of a bounded step
export const STEP_TURN = (5 * Math.PI) / 180; // [rad] of a bounded step that only turns
export const SPEEDS = { slow: 0.25, medium: 0.5, fast: 1 }; // shares of the limits

/** The moves of the buttons of each joint alone, of which there is one set in manual mode. */
export function jointMoves(hello) {
  return hello.joints.flatMap((_, i) => [`joint/${i + 1}-`, `joint/${i + 1}+`]);
}

/** The joint, counted from 1, whose own button a move is; null for any other button. */
export function jointOf(move) {
  const own = OWN.exec(move);
  return own && Number(own[1].slice(6));
}

/**
 * The part that a button moves: in shared mode the hand. In manual mode there are two sets of
 * buttons, of the platform and of the joints; Up and Down move `joint`, the one that was used last.
 */
export function partOf(mode, move, joint, hello) {
  if (mode !== "manual") return "hand";
  const own = OWN.exec(move);
  if (own) return own[1];
  return move in JOINT || hello.base === "fixed" ? `joint/${joint}` : "platform";
}

/** What the buttons of a part do. */
function table(part, base) {
  if (part === "hand") return HAND;
  if (part === "platform") return base === "holonomic" ? HOLONOMIC : DIFFERENTIAL;
  return JOINT;
}

/** A button's name in the table of its part. */
function nameIn(move) {
  const own = OWN.exec(move);
  if (!own) return move;
  return own[2] === "+" ? "up" : "down";
}

/** Whether a button moves something of this robot (`hello`) in a mode. */
export function moves(move, mode, joint, hello) {
  if (move in GRIP) return hello.gripper;
  const part = partOf(mode, move, joint, hello);
  if (part.startsWith("joint/") && hello.joints.length === 0) return false;
  return nameIn(move) in table(part, hello.base);
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
 * `view` is what the person chose: mode, joint, frame, camera heading [rad], speed, style.
 */
export function jogFields(move, view, hello) {
  const part = partOf(view.mode, move, view.joint, hello);
  const rows = table(part, hello.base);
  const share = SPEEDS[view.speed];
  const own = (rows[nameIn(move)] ?? Object.values(rows)[0].map(() => 0)).map((one) => one * share);
  const fields = { ...asFrame(view), part, speeds: own, grip: GRIP[move] ?? 0 };
  if (view.style === "step") fields.step = stepOf(move, part, hello);
  return fields;
}

/**
 * Return the fields of the jog of a joystick: deflections -1 to 1 by move. In manual mode one part
 * moves at a time: that of the largest deflection.
 */
export function stickFields(deflections, view, hello) {
  const most = (one, other) => (deflections[other] > deflections[one] ? other : one);
  const part = partOf(view.mode, Object.keys(deflections).reduce(most), view.joint, hello);
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
