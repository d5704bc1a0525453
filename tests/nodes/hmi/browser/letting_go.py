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
NOTES = """() => {
  Object.assign(window, {jogsAfter: 0, armed: false, over: false, heldThen: false});
  const {send} = WebSocket.prototype;
  WebSocket.prototype.send = function (text) {
    if (over && JSON.parse(text).type === 'jog') jogsAfter += 1;
    return send.call(this, text);
  };
  for (const kind of ['pointerup', 'pointerdown', 'keyup', 'contextmenu', 'blur',
                      'visibilitychange', 'unplugged']) {
    addEventListener(kind, () => {
      if (armed && !over) heldThen = document.querySelector('[data-move].held') !== null;
      over ||= armed;
    }, {capture: true});
  }
}"""
"""Counts in `jogsAfter` what the page sends of a held button after the event that lets go of it.

That is the first one after `armed` was set. Whether a button was still held then is in `heldThen`:
on a busy machine a press may end before.
"""
CLOCK = """() => {
  window.said = [];
  addEventListener('pointerdown', () => window.since = performance.now(), true);
  addEventListener('pointerdown', () => {  // after STOP itself
    setTimeout(() => window.half = performance.now() - since, 500);
  });
  new MutationObserver(() => {
    const text = document.body.innerText;
    const known = ['NOT CONFIRMED', 'confirmed by the robot', 'STOP sent'];
    const what = known.find(words => text.includes(words));
    if (what && said.at(-1)?.[0] !== what) said.push([what, performance.now() - since]);
  }).observe(document.body, {childList: true, subtree: true, characterData: true});
}"""
"""Notes in `said` what the page says of a STOP, and how long after the pointer went down [ms].

`half` is when a timer of half a second was over: on a busy machine later than that.
"""
PAD = """() => {
  window.pad = {id: 'a stick', index: 0, connected: true, axes: [0, -1, 0, 0], buttons: []};
  navigator.getGamepads = () => [window.pad];
}"""
"""Plugs in a joystick which is held forward."""


_sessions = WeakKeyDictionary[Any, Any]()  # of each page one, which knows what is touched


def touch(page: Any, kind: str, *points: tuple[float, float]) -> None:
    """Send a touch as the system does: all points that are touched now."""
    session = _sessions.get(page) or page.context.new_cdp_session(page)
    _sessions[page] = session
    touches = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
    session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})


def unconfirmed(page: Any) -> tuple[float, float]:
    """Return when the page said NOT CONFIRMED, and when half a second was over [ms]."""
    page.wait_for_timeout(20)  # the other timer is due as well
    after: float = page.evaluate("said.find(([what]) => what === 'NOT CONFIRMED')[1]")
    half: float = page.evaluate("half")
    return after, half
