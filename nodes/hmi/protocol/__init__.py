"""What the page's server and the browser send each other: tagged JSON, one message per frame.

Every message is a JSON object whose field `type` is the name in quotes below. Units are decided
here once: metres, radians, seconds, metres per second; orientations are unit quaternions x, y, z,
w; everything is in the world frame (z up), at plant time `t`, unless it says otherwise. A browser
never sends a time: the server judges how old things are by its own clock.

**Numbers.** The server numbers its states. The browser answers each state that it has *painted*
(in the callback of `requestAnimationFrame`, not when the frame arrived) by that number: in `jog`
while a button is held, else in `painted`. Of a browser that does not answer, the server stops
sending states after half a second's worth, and then sends one a second: nothing queues up.

**A press.** The browser counts its presses from 1 on. While a button is held it sends `jog` every
`Times.jog`, always with the number of that press, and `let_go` when it is released. The server
answers by `you.press` (the press that moves the robot) and by `ended` once it does not any more. A
press that has ended, whatever the reason, is dead: the browser has to send a new number, which
only a person's new press may give it. The browser sends a `jog` only if `bufferedAmount` of its
socket is small (under 2 kB): what waits there would arrive late.

**STOP.** The browser sends `halt` with an `id` of its own and shows *sent*. The server asks the
robot and answers by `halted`: `confirmed` true as soon as the robot has said that it is halted; the
browser then shows its own time from the click to this message. If 500 ms (`Times.confirm`) have
passed since the click without it, by the browser's own clock, or on `confirmed` false (the server
has heard nothing of the robot for as long), it shows NOT CONFIRMED. The server goes on asking the
robot; so a `halted` with `confirmed` true may still follow one with false. A socket that is closed
or not yet open is NOT CONFIRMED at once.

**Frames of a jog.** `x` forward, `y` left, `z` up, and turns about these by the right-hand rule. So
`Yaw left` is +`wz`, `Pitch up` is -`wy`, `Roll left` (its left side sinks) is -`wx`.
- `mine`: as the person sees it: forward is where the camera (or the person) looks, made level.
  `camera` is that direction's heading in the world, from x towards y.
- `robot`: the platform's (the base's) own forward, left and up.
- `gripper`: forward is where the grip points (the hand's x or z, the server knows), left is the
  hand's y.
"""
