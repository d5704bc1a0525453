// A group of choices as big radio buttons, of which one has the focus (roving tabindex).

/**
 * Fill `group` (role radiogroup) with `options` [{value, text, label?}].
 *
 * With `follow` the arrow keys choose, as in a form; without, they move the focus only, and Space,
 * Enter or a press chooses: so nobody passes through a mode of the robot on the way to another.
 * `text` is a function, so that the language can change. Returns { set, enable }.
 */
export function choices(group, options, choose, follow = false) {
  group.setAttribute("role", "radiogroup");
  group.replaceChildren();
  const buttons = new Map();
  let chosen = null;
  for (const { value, text } of options) {
    const button = document.createElement("button");
    button.type = "button";
    button.dataset.value = value;
    button.setAttribute("role", "radio");
    button.onclick = () => {
      if (button.getAttribute("aria-disabled") !== "true") choose(value);
    };
    button.onfocus = () => rove(button);
    buttons.set(value, { button, text });
    group.append(button);
  }
  group.onkeydown = (event) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    const all = [...group.children];
    const next = all[(all.indexOf(document.activeElement) + by + all.length) % all.length];
    next.focus();
    if (follow) next.click();
  };

  function rove(to) {
    for (const { button } of buttons.values()) button.tabIndex = button === to ? 0 : -1;
  }

  function set(value) {
    chosen = value;
    for (const [each, { button }] of buttons) {
      button.setAttribute("aria-checked", String(each === value));
    }
    if (!group.contains(document.activeElement)) {
      rove((buttons.get(value) ?? buttons.values().next().value)?.button);
    }
  }

  function name() {
    for (const { button, text } of buttons.values()) button.textContent = text();
  }

  group.named?.abort();
  group.named = new AbortController();
  document.addEventListener("language", name, { signal: group.named.signal });
  name();
  set(chosen);
  return { set };
}
