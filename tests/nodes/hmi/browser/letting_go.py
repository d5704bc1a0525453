"""What a person's hands and browser do, as the tests of the page need it."""

from typing import Any
from weakref import WeakKeyDictionary

HIDE = """() => {
  Object.defineProperty(document, 'visibilityState', {value: 'hidden', configurable: true});
  document.dispatchEvent(new Event('visibilitychange'));
}"""
SHOW = """() => {
  delete document.visibilityState;
  document.dispatchEvent(new Event('visibilitychange'));
}"""
CLOCK = """() => {
  window.said = [];
  addEventListener('pointerdown', () => window.since = performance.now(), true);
  new MutationObserver(() => {
    const text = document.body.innerText;
    const known = ['NOT CONFIRMED', 'confirmed by the robot', 'STOP sent'];
    const what = known.find(words => text.includes(words));
    if (what && said.at(-1)?.[0] !== what) said.push([what, performance.now() - since]);
  }).observe(document.body, {childList: true, subtree: true, characterData: true});
}"""
"""Notes in `said` what the page says of a STOP, and how long after the pointer went down [ms]."""


_sessions = WeakKeyDictionary[Any, Any]()  # of each page one, which knows what is touched


def touch(page: Any, kind: str, *points: tuple[float, float]) -> None:
    """Send a touch as the system does: all points that are touched now."""
    session = _sessions.get(page) or page.context.new_cdp_session(page)
    _sessions[page] = session
    touches = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
    session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})


def middle(button: Any) -> tuple[float, float]:
    """Return the middle of a button on the page [px]."""
    box = button.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
