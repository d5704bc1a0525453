"""How a platform leads a hand that it carries behind its axle."""

from agents.adaptation import SteadierGain
from agents.agent import Array
from agents.arithmetic import arctan2, greater, ramp, sqrt
from agents.pursuit import Pursuit
from agents.scene import Scene


class Towing:
    """Drives as one who tows: past the goal, and on so that the hand comes to it from behind.

    A hand behind the axle swings out when the platform turns towards the goal, and a platform that
    made up for it would end facing the other way, which is only good for going backwards. So it
    does not look at the hand, but at where its own axle will be once it faces where the goal goes,
    with the hand carried as now; it drives to that line and keeps to it (`Pursuit`), the more
    firmly the less comes of it. What counts is how fast the hand gets on, and a little how fast it
    does so itself: else it and the first joint, which can move the hand as well, would take turns.
    To the person beside the robot this is a cart that takes a bend wide enough for what it draws,
    and never backs up.
    """

    BEHIND = -0.15, 0.0  # [m] of the hand ahead of the axle: towed and nothing else, not towed
    LOOKS = 0.2054  # [m] ahead along the line, or as far as the hand is behind it if that is more
    TURNS = 1.882  # [rad/s] for each radian off that way
    AGREES = 4.4  # [1/s] at which it takes on the goal's speed
    CATCHES_UP = 8.0  # [1/s2] for each metre that it is behind its place
    KEENEST = 4.0  # times that at the most, as long as it hardly comes nearer to its place
    OWN = 0.3  # share of its own speed, beside the hand's, in what counts as the speed it has

    def __init__(self, top: float) -> None:
        """Drive at most at `top` [m/s]."""
        self._pursuit = Pursuit(
            top, turns=self.TURNS, agrees=self.AGREES, catches_up=self.CATCHES_UP
        )
        self._keen = SteadierGain(1.0, self.KEENEST)

    @classmethod
    def share(cls, scene: Scene) -> Array:
        """Return how much (...), 0 to 1, the hand is towed."""
        return (1 - ramp(scene.carried, *cls.BEHIND)) * scene.led_on

    def speeds(self, elapsed: float, scene: Scene) -> tuple[Array, Array]:
        """Return linear (...) [m/s] and angular (...) [rad/s], `elapsed` [s] after the last."""
        speed = greater(scene.speed, 1e-6)
        on_x, on_y = scene.going[0] / speed, scene.going[1] / speed
        along, beside = Pursuit.place(scene, (on_x, on_y), scene.carried, scene.aside)
        course = arctan2(on_y, on_x) + arctan2(beside, greater(abs(scene.carried), self.LOOKS))
        hands = scene.drift[0] * on_x + scene.drift[1] * on_y
        own = scene.linear * (scene.ahead[0] * on_x + scene.ahead[1] * on_y)
        slower = scene.speed - hands - self.OWN * (own - hands)
        keen = self._keen.after(along)
        return self._pursuit.speeds(elapsed, scene, keen * along, sqrt(keen) * slower, course)
