"""Calculations with rotations; beside stock's in interop/test_tf_transformations.py."""

from __future__ import annotations

from math import pi

import pytest

from pyros1.tf import transformations as tr


def test_roll_pitch_yaw_are_about_the_axes_that_stand_still() -> None:
    quarter = tr.quaternion_from_euler(0, 0, pi / 2)
    assert quarter == pytest.approx([0, 0, 0.5**0.5, 0.5**0.5])
    matrix = tr.quaternion_matrix(quarter)
    assert [row[0] for row in matrix[:3]] == pytest.approx([0, 1, 0]), "x goes to y"
    assert tr.euler_from_quaternion(tr.quaternion_from_euler(0.1, -0.2, 3.0)) == pytest.approx((0.1, -0.2, 3.0))


def test_turning_axes_are_standing_axes_backwards() -> None:
    assert tr.quaternion_from_euler(0.1, 0.2, 0.3, "rzyx") == pytest.approx(
        tr.quaternion_from_euler(0.3, 0.2, 0.1, "sxyz")
    )


@pytest.mark.parametrize("axes", ["", "xyz", "sxxz", "qxyz", "sxyq", "sxyzz"])
def test_axes_that_are_none(axes: str) -> None:
    with pytest.raises(ValueError, match="axes must be"):
        tr.quaternion_from_euler(0, 0, 0, axes)


def test_matrices() -> None:
    move = tr.concatenate_matrices(tr.translation_matrix([1, 2, 3]), tr.rotation_matrix(pi, [0, 0, 2]))
    assert tr.translation_from_matrix(move) == [1, 2, 3]
    assert tr.is_same_transform(tr.concatenate_matrices(move, tr.inverse_matrix(move)), tr.identity_matrix())
    assert tr.quaternion_from_matrix(move) == pytest.approx([0, 0, 1, 0])
    with pytest.raises(ValueError, match="no inverse"):
        tr.inverse_matrix(tr.scale_matrix(0.0))


def test_random_rotations_have_unit_length() -> None:
    assert tr.vector_norm(tr.random_quaternion()) == pytest.approx(1.0)
    assert tr.is_same_transform(tr.random_rotation_matrix([0, 0.25, 0.5]), tr.quaternion_matrix([1, 0, 0, 0]))
    assert tr.quaternion_slerp([0, 0, 0, 1], [0, 0, 0, -1], 0.5) == [0, 0, 0, 1]
