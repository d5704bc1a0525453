// Pointers and keys on the buttons that move: what begins a press, and everything that ends it.

const SLACK = 24; // [px] that a shaking finger may leave the button and still hold it

/**
 * Connect a button that moves: `press(source, move)` begins a press of `button.dataset.move`, or
 * says why not; `presses` is where it ends.
 */
export function holdButton(button, presses, press) {
  const { move } = button.dataset;

  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    event.stopPropagation(); // not also "anywhere" below
    const source = pointer(event);
    press(source, move);
    if (presses.held?.source === source) button.setPointerCapture(event.pointerId);
  });
  button.addEventListener("pointermove", (event) => {
    if (!inside(button, event)) presses.lose(pointer(event), "press.left");
  });
  // After pointerup this changes nothing; before it, the button has lost its pointer.
  button.addEventListener("lostpointercapture", (event) => presses.up(pointer(event)));
  button.addEventListener("pointerleave", (event) => {
    // The captured pointer leaves only when it is let go. A finger that is lifted leaves too:
    // a step or a click-click press goes on then, as after the click of a mouse that stays.
    if (event.pointerType === "mouse") presses.lose(pointer(event), "press.left");
  });

  button.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault(); // no click besides
    if (event.repeat) return;
    event.stopPropagation();
    press(`key ${event.code}`, move);
  });
  button.addEventListener("keyup", (event) => {
    if (event.key === " ") event.preventDefault();
  });
  button.addEventListener("blur", () => {
    // The blur comes after the next button's pointerdown: only this button's keys have lost it.
    if (presses.held?.move === move && presses.held.source.startsWith("key ")) {
      presses.end("press.left");
    }
  });

  button.addEventListener("click", (event) => {
    // A click without pointer or key (which has no count) is a screen reader's or a voice's: it
    // cannot hold, so a hold becomes a step.
    if (event.detail === 0) press("click", move);
  });
}

/** End presses by what happens anywhere in the window, or to it. */
export function watchWindow(presses) {
  addEventListener("pointerup", (event) => presses.up(pointer(event)));
  addEventListener("pointercancel", (event) => presses.lose(pointer(event), "press.lost"));
  addEventListener("keyup", (event) => presses.up(`key ${event.code}`));
  addEventListener("pointerdown", (event) => {
    if (presses.held !== null && presses.held.source !== pointer(event)) {
      presses.end(presses.held.style === "hold" ? "press.second" : "press.released");
    }
  });
  addEventListener("keydown", (event) => {
    if (event.repeat || presses.held === null || modifier(event)) return;
    if (presses.held.source !== `key ${event.code}`) {
      presses.end(presses.held.style === "hold" ? "press.second" : "press.released");
    }
  });
  addEventListener("contextmenu", (event) => {
    // A long touch asks for a menu too. That is no menu here but somebody who holds a button.
    const onButton = event.target.closest?.("[data-move]");
    if (onButton) event.preventDefault();
    if (!(onButton && event.pointerType === "touch")) presses.end("press.menu");
  });
  addEventListener("blur", () => presses.end("press.away"));
  addEventListener("pagehide", () => presses.end("press.away"));
  document.addEventListener("visibilitychange", () => {
    if (document.visibilityState !== "visible") presses.end("press.away");
  });
}

function pointer(event) {
  return `pointer ${event.pointerId}`;
}

function modifier(event) {
  return ["Shift", "Control", "Alt", "Meta"].includes(event.key);
}

function inside(button, { clientX, clientY }) {
  const { left, right, top, bottom } = button.getBoundingClientRect();
  return (
    clientX > left - SLACK &&
    clientX < right + SLACK &&
    clientY > top - SLACK &&
    clientY < bottom + SLACK
  );
}
