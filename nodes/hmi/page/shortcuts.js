// Single keys that move the robot: off until a person switches them on (WCAG 2.1.4).

const KEYS = {
  ArrowUp: "forward",
  ArrowDown: "back",
  ArrowLeft: "left",
  ArrowRight: "right",
  PageUp: "up",
  PageDown: "down",
  KeyO: "open",
  KeyC: "close",
};

/** Connect them: `on()` tells whether they are on, `press` and `up` begin and end a press. */
export function shortcuts({ on, press, up, halt }) {
  addEventListener("keydown", (event) => {
    if (!on() || elsewhere(event)) return;
    if (event.code === "Escape") halt();
    const move = KEYS[event.code];
    if (move === undefined) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!event.repeat) press(`key ${event.code}`, move);
  });
  addEventListener("keyup", (event) => up(`key ${event.code}`));
}

/** Whether the key means something else: in a text, a list or a group of choices, or with Ctrl. */
function elsewhere(event) {
  if (event.ctrlKey || event.altKey || event.metaKey) return true;
  return Boolean(event.target.closest?.("input, select, textarea, [role=radiogroup]"));
}
