"""Code written out for a chain of links, against the same chain as products of matrices."""

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from plant.robot import Array
from plant.straight_line import Link, forward_functions

# what is left out where it is 0 or 1 must come to the same; the columns need not be a rotation's
weights = st.sampled_from([0.0, -0.0, 1.0, -1.0]) | st.floats(-2.0, 2.0, allow_subnormal=False)
links = st.tuples(*[weights] * 12)
angles = st.floats(-7.0, 7.0)


def matrix(link: Link) -> Array:
    """The (4, 4) matrix whose upper columns a link holds one after the other."""
    whole = np.eye(4)
    whole[:3] = np.array(link).reshape(4, 3).T
    return whole


def about_z(angle: float) -> Array:
    """A (4, 4) turn about z."""
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return turn


def flat(result: tuple[Any, ...]) -> list[Any]:
    """All numbers of a result, one after the other."""
    tip, rotation, points, axes = result
    return [*tip, *rotation, *(number for vector in (*points, *axes) for number in vector)]


@given(st.lists(st.tuples(links, angles), min_size=2, max_size=5), angles, angles)
def test_any_chain_comes_to_the_product_of_its_matrices(
    chain: list[tuple[Link, float]], x: float, y: float
) -> None:
    frame = np.eye(4)
    frame[:2, 3] = x, y
    frames = []
    for link, angle in chain:
        frame = frame @ about_z(angle) @ matrix(link)
        frames.append(frame)
    links, angles = zip(*chain, strict=True)
    said = flat(forward_functions(links)[0](x, y, *angles))
    joints = np.array(frames[:-1])
    expected = [frame[:3, 3], frame[:3, :3], joints[:, :3, 3], joints[:, :3, 2]]
    np.testing.assert_allclose(said, np.concatenate([each.ravel() for each in expected]), atol=1e-9)
    alike = np.array([x, y, *angles])[:, None].repeat(3, 1)
    many = flat(forward_functions(links)[1](*alike))
    for number, numbers in zip(said, many, strict=True):
        np.testing.assert_allclose(numbers, number, atol=1e-9)


def test_what_is_multiplied_by_0_or_1_is_not_worked_out() -> None:
    plain = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    general = (0.6, 0.8, 0.0, -0.8, 0.6, 0.0, 0.0, 0.0, 1.0, 0.1, 0.2, 0.3)
    functions = [forward_functions([link] * 3)[0] for link in (plain, general)]
    sizes = [len(function.__code__.co_code) for function in functions]
    assert sizes[0] < sizes[1] / 2
