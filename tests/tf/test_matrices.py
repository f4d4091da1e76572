"""pyros1.tf.transformations: matrices, arcballs and the special cases of quaternions, by what they do with points."""

from __future__ import annotations

from itertools import product
from math import pi
from typing import Any

import numpy as np
import pytest

from pyros1.tf import transformations as tr

CORNERS = list(product((-1, 1), repeat=3))


def mapped(matrix: Any, point: Any) -> Any:
    """Return where a point goes."""
    x, y, z, w = matrix @ np.append(point, 1.0)
    return np.array((x, y, z)) / w


def test_a_box_is_mapped_to_a_cube() -> None:
    low, high = np.array((1.0, -2.0, 3.0)), np.array((2.0, 5.0, 9.0))
    matrix = tr.clip_matrix(1, 2, -2, 5, 3, 9)
    for corner in CORNERS:
        assert mapped(matrix, (low + high) / 2 + (high - low) / 2 * corner) == pytest.approx(corner)


def test_a_frustum_is_mapped_to_a_cube() -> None:
    """The viewer looks along z, and the far end is as much larger as it is farther away."""
    left, right, bottom, top, near, far = 1.0, 2.0, -2.0, 5.0, 3.0, 9.0
    matrix = tr.clip_matrix(left, right, bottom, top, near, far, perspective=True)
    corners = {
        tuple(np.round(mapped(matrix, np.array((x, y, near)) * (z / near)), 9))
        for x, y, z in product((left, right), (bottom, top), (near, far))
    }
    assert corners == {tuple(map(float, corner)) for corner in CORNERS}


@pytest.mark.parametrize("bounds", [(2, 2, 0, 1, 1, 2), (0, 1, 3, 2, 1, 2), (0, 1, 0, 1, 2, 2)])
def test_bounds_without_volume(bounds: Any) -> None:
    with pytest.raises(ValueError, match="left < right, bottom < top, near < far"):
        tr.clip_matrix(*bounds)


def test_a_frustum_begins_in_front_of_the_eye() -> None:
    with pytest.raises(ValueError, match="near must be positive"):
        tr.clip_matrix(0, 1, 0, 1, 0, 2, perspective=True)


def test_what_is_composed_of_nothing_changes_nothing() -> None:
    assert np.array_equal(tr.compose_matrix(), np.identity(4))


def test_a_matrix_is_composed_of_its_parts() -> None:
    assert mapped(tr.compose_matrix(scale=(2, 3, 4)), (1, 1, 1)) == pytest.approx((2, 3, 4))
    assert mapped(tr.compose_matrix(shear=(2, 3, 4)), (1, 10, 100)) == pytest.approx((321, 410, 100))
    assert mapped(tr.compose_matrix(angles=(0, 0, pi / 2)), (1, 0, 0)) == pytest.approx((0, 1, 0))
    assert mapped(tr.compose_matrix(translate=(1, 2, 3)), (0, 0, 0)) == pytest.approx((1, 2, 3))
    assert mapped(tr.compose_matrix(perspective=(0, 0, 1, 2)), (2, 4, 6)) == pytest.approx(np.array((2, 4, 6)) / 8)
    both = tr.compose_matrix(scale=(2, 2, 2), angles=(0, 0, pi / 2), translate=(1, 0, 0))
    assert mapped(both, (1, 0, 0)) == pytest.approx((1, 2, 0)), "the scale comes first, the translation last"


def test_a_shear_is_along_its_plane() -> None:
    matrix = tr.shear_matrix(pi / 4, (1, 0, 0), (0, 0, 5), (0, 0, 1))
    assert mapped(matrix, (3, 4, 5)) == pytest.approx((3, 4, 5)), "in the plane"
    assert mapped(matrix, (3, 4, 7)) == pytest.approx((5, 4, 7))
    with pytest.raises(ValueError, match="the direction must lie in the plane"):
        tr.shear_matrix(pi / 4, (1, 0, 1), (0, 0, 5), (0, 0, 1))


def test_what_is_no_projection() -> None:
    with pytest.raises(ValueError, match="the matrix is not a projection"):
        tr.projection_from_matrix(np.identity(4), pseudo=True)


def test_a_quaternion_of_length_zero_rotates_nothing() -> None:
    assert np.array_equal(tr.quaternion_matrix((0, 0, 0, 1e-9)), np.identity(4))


def test_a_spin_that_undoes_the_way_to_a_quaternion_leaves_it_at_the_start() -> None:
    """Half a turn about z is a quarter turn of the quaternion: half of a half turn, as spins are counted."""
    start, half_turn = (0, 0, 0, 1), (0, 0, 1, 0)
    assert tr.quaternion_slerp(start, half_turn, 0.5) == pytest.approx((0, 0, 0.5**0.5, 0.5**0.5))
    assert tr.quaternion_slerp(start, half_turn, 0.5, spin=-0.5) == pytest.approx(start)


def test_a_drag_across_half_the_ball_is_a_half_turn() -> None:
    ball = tr.Arcball()
    ball.place((100, 100), 100)
    ball.down((100, 100))
    ball.drag((200, 100))
    assert mapped(ball.matrix(), (0, 0, 1)) == pytest.approx((0, 0, -1)), "a quarter of the ball, turned twice as far"
    ball.drag((100, 100))
    assert ball.matrix() == pytest.approx(np.identity(4)), "back where it began"
    ball.drag((300, 100))
    assert mapped(ball.matrix(), (0, 0, 1)) == pytest.approx((0, 0, -1)), "outside of the ball is at its edge"


@pytest.mark.parametrize("initial", [tr.quaternion_from_euler(0.1, 0.2, 0.3) * 5, tr.euler_matrix(0.1, 0.2, 0.3)])
def test_a_ball_begins_as_it_is_told(initial: Any) -> None:
    assert tr.Arcball(initial).matrix() == pytest.approx(tr.euler_matrix(0.1, 0.2, 0.3))


def test_a_ball_begins_with_a_rotation() -> None:
    with pytest.raises(ValueError, match="initial not quaternion or matrix"):
        tr.Arcball((1, 2, 3))


@pytest.mark.parametrize(
    ("point", "axis", "expected"),
    [
        ((0, 0.6, 0.8), (1, 0, 0), (0, 0.6, 0.8)),
        ((0, 0.6, -0.8), (1, 0, 0), (0, -0.6, 0.8)),
        ((0, 0, 1), (0, 0, 1), (1, 0, 0)),
        ((1, 0, 0), (1, 0, 0), (0, 1, 0)),
    ],
    ids=["in the plane", "behind", "on the axis of view", "on another axis"],
)
def test_a_point_is_moved_to_the_plane_of_an_axis(point: Any, axis: Any, expected: Any) -> None:
    assert tr.arcball_constrain_to_axis(point, axis) == pytest.approx(expected)


def test_a_constrained_drag_turns_about_one_axis_only() -> None:
    ball = tr.Arcball()
    ball.place((100, 100), 100)
    ball.setaxes((1, 0, 0), (0, 1, 0))
    ball.setconstrain(True)
    ball.down((100, 100))
    ball.drag((150, 110))
    assert mapped(ball.matrix(), (1, 0, 0)) == pytest.approx((1, 0, 0)), "the first axis: the drag began on both planes"
    assert ball.matrix() != pytest.approx(np.identity(4))
