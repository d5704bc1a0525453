"""How a platform keeps its axle to a place of its own beside a moving goal."""

from agents.agent import Array
from agents.arithmetic import arctan2, cos, greater, lesser, sin
from agents.scene import Scene


class Pursuit:
    """Drives to a line and along it, looking a little ahead (pure pursuit; Coulter 1992).

    The line is that of the axle's place: where it is when the hand is over the goal, and the
    platform faces along the line with the hand carried as it is to be.
    """

    def __init__(self, top: float, *, turns: float, agrees: float, catches_up: float) -> None:
        """Drive at most at `top` [m/s].

        turns: [rad/s] for each radian off the way to go
        agrees: [1/s] at which it takes on the speed of its place
        catches_up: [1/s2] for each metre that it is behind its place
        """
        self._top, self._turns = top, turns
        self._agrees, self._catches_up = agrees, catches_up

    @staticmethod
    def place(
        scene: Scene, line: tuple[Array, Array], ahead: Array, left: Array
    ) -> tuple[Array, Array]:
        """Return how far (...) [m] along the line, and to its left, the axle's place is from it.

        line: x and y of its direction; ahead, left: (...) [m] of the axle that the hand is carried
        """
        goal_x, goal_y = scene.hand[0] + scene.missing[0], scene.hand[1] + scene.missing[1]
        return (
            goal_x * line[0] + goal_y * line[1] - ahead,
            goal_y * line[0] - goal_x * line[1] - left,
        )

    def speeds(
        self, elapsed: float, scene: Scene, along: Array, slower: Array, course: Array
    ) -> tuple[Array, Array]:
        """Return linear (...) [m/s] and angular (...) [rad/s], `elapsed` [s] after the last.

        along: (...) [m] to its place; slower: (...) [m/s] than that; course: (...) [rad] to head
        """
        off = course - scene.heading
        linear = scene.linear + elapsed * (self._agrees * slower + self._catches_up * along)
        return (
            lesser(linear, greater(cos(off), 0.0) * self._top),
            self._turns * arctan2(sin(off), cos(off)),
        )
