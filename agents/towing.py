"""A hand behind the axle: what is to be at a plan's end for it to stay over its goal."""

from typing import NamedTuple

import numpy as np

from agents.agent import Array, Places

OBLIQUE = 0.95
"""[] Sine of the most that a platform heads off where the goal goes, to make up for the hand's own
motion to the side and for the goal's turning. Chosen: at 1 the hand would drift as fast as the goal
goes, or is as far behind the axle as the goal's circle is wide; 0.8 does as well but for circles
narrower than 1.25 times that, of which the hand then stays 20 to 50 mm off."""


class Tail(NamedTuple):
    """What is to be at the plan's end for a hand behind the axle to stay over its goal.

    Attributes:
        ahead: (..., 1) a, how far ahead of the axle the hand is [m].
        heading: (..., 1) where the platform is to head, as e^i psi.
        weight: (..., 1) T = 1 / (2 z), how long what is off there lasts [s].
    """

    ahead: Array
    heading: Places
    weight: Array


def tail_of(going: Places, bend: Array, hand: Places, times: Array, end: Array) -> Tail:
    """Return what is to be at the plan's end.

    A hand at h = a + i b, with a < 0, keeps to a goal that goes at V to phi, which turns at w,
    while V sin(phi - psi) = a psi' + b'. This is unstable at z = V / |a| (it has a zero there), so
    psi is its bounded solution: backwards, from beyond the end, phi - psi follows
    asin((a w + b') / V), where it is steady, with the time constant 1 / (z cos(phi - psi))
    (Devasia, Chen and Paden 1996, "Nonlinear inversion-based output tracking"). Where it is off
    by y to the side at the axle, an error of 2 y e^-zt brings it back with the least squares, so
    that the rest of the cost is rho(2 y) / (2 z); slower than the horizon H, it need not be
    brought back: 1 / z becomes V |a| / (V^2 + a^2 / H^2).

    Args:
        going: (...) how the goal goes now [m/s].
        bend: (...) how fast its course turns, w [rad/s].
        hand: (..., N) as of a course, at the ends of the M intervals of a plan and on [m].
        times: (N,) of these [s].
        end: (M,) of the intervals [s].
    """
    last = len(end) - 1
    times, hand = times[last:], hand[..., last:]
    step = times[1:] - times[:-1]
    speed = np.maximum(np.abs(going), 1e-9)[..., None]
    drift = (hand[..., 1:] - hand[..., :-1]).imag / step
    sine = (hand[..., 1:].real * bend[..., None] + drift) / speed
    sine = sine.clip(-OBLIQUE, OBLIQUE)
    cosine = np.sqrt(1 - sine**2)
    steady = cosine - 1j * sine
    behind = np.maximum(-hand.real, 0.0)
    kept = np.ones(hand.shape)
    kept[..., 1:] = np.exp(-speed * cosine * step / np.maximum(behind[..., 1:], 1e-9))
    after = kept.cumprod(axis=-1)
    aside = (steady * (after[..., 1:] - after[..., :-1])).sum(axis=-1)
    aside = after[..., -1] * steady[..., -1] - aside
    heading = aside * going * np.exp(1j * bend * end[-1])
    heading = heading / np.maximum(np.abs(heading), 1e-9)
    speed, behind = speed[..., 0], behind[..., 0]
    weight = speed * behind / (speed**2 + (behind / end[-1]) ** 2) / 2
    ahead = hand[..., 0].real
    return Tail(ahead[..., None], heading[..., None], weight[..., None])


def beside_goal(tail: Tail, heading: Places, missing: Places) -> Places:
    """Twice what is missing at the axle (..., C) [m] at the plan's end, beside the hand."""
    beside: Places = 2 * (missing[..., -1] + tail.ahead * (heading - tail.heading))
    return beside
