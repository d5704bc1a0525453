// What is at the edge of both views: STOP, Release, what is said of them, and who drives.

/** Return an element with attributes and children. */
function make(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

function button(id, word, more = {}) {
  return make("button", { "type": "button", id, "data-word": word, ...more });
}

/** Fill the bar `#stopbar`. */
export function buildStopBar() {
  const says = make("div", { class: "says" },
    make("p", { id: "stop-state" }),
    make("p", { id: "alert", role: "alert" }));
  const status = make("p", { "id": "status", "role": "status", "aria-atomic": "false" },
    make("span", { id: "status-mode" }), " ",
    make("span", { id: "status-driver" }), " ",
    make("span", { id: "said" }));
  const asked = make("div", { "id": "asked", "role": "group", "aria-labelledby": "asked-text", "hidden": "" },
    make("p", { "id": "asked-text", "data-word": "take.ask" }),
    button("take-yes", "take.yes"),
    button("take-no", "take.no"));
  document.getElementById("stopbar").append(
    make("div", { class: "stoprow" },
      button("stop", "stop.button", { "aria-describedby": "stop-what" }),
      says,
      button("release", "release.button")),
    make("div", { class: "facts" },
      status,
      make("p", { id: "age" }),
      make("p", { id: "viewers" }),
      button("take", "take.button", { hidden: "" }),
      asked),
    make("p", { "id": "stop-what", "class": "small", "data-word": "stop.what" }));
}
