"""Calculations with rotations; beside stock's in interop/test_tf_transformations.py."""

from __future__ import annotations

from math import pi

import pytest

from pyros1.tf import transformations as tr
from pyros1.tf.quaternions import dot


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


def test_a_matrix_is_taken_to_pieces_and_made_again() -> None:
    parts = ([1.5, -2.0, 0.5], [0.1, -0.2, 0.3], [0.4, -0.5, 0.6], [1, 2, 3], [0.01, 0.02, 0.03, 1.0])
    matrix = tr.compose_matrix(*parts)
    assert tr.is_same_transform(tr.compose_matrix(*tr.decompose_matrix(matrix)), matrix)
    with pytest.raises(ValueError, match="singular"):
        tr.decompose_matrix(tr.scale_matrix(0.0))


def test_what_a_matrix_does() -> None:
    axis = [1.0, 2.0, -2.0]
    for angle in (0.3, -0.3, pi, 3.0):
        matrix = tr.rotation_matrix(angle, axis, [4, 5, 6])
        assert tr.is_same_transform(tr.rotation_matrix(*tr.rotation_from_matrix(matrix)), matrix)
    assert tr.rotation_from_matrix(tr.identity_matrix())[0] == 0.0
    plane = tr.reflection_matrix([1, 2, 3], axis)
    assert tr.is_same_transform(tr.reflection_matrix(*tr.reflection_from_matrix(plane)), plane)
    for matrix in (tr.scale_matrix(-3.0, [1, 2, 3]), tr.scale_matrix(2.5, [1, 2, 3], axis), tr.scale_matrix(1.0)):
        assert tr.is_same_transform(tr.scale_matrix(*tr.scale_from_matrix(matrix)), matrix)
    shear = tr.shear_matrix(-0.7, [2, 1, 2], [3, 1, 4], axis)
    assert tr.is_same_transform(tr.shear_matrix(*tr.shear_from_matrix(shear)), shear)


@pytest.mark.parametrize("more", [{}, {"direction": [1, 1, 0]}, {"perspective": [7, 8, -9]}])
def test_projections_are_recognized(more: dict[str, list[float]]) -> None:
    matrix = tr.projection_matrix([1, 2, 3], [1, 2, -2], **more)
    assert tr.is_same_transform(tr.projection_matrix(*tr.projection_from_matrix(matrix)), matrix)
    assert tr.is_same_transform(tr.concatenate_matrices(matrix, matrix), matrix), "what lies in the plane stays there"


def test_pseudo_projection_keeps_the_depth() -> None:
    plane, eye = ([1, 2, 3], [1, 2, -2]), [7, 8, -9]
    pseudo = tr.projection_matrix(*plane, perspective=eye, pseudo=True)
    flat = tr.concatenate_matrices(tr.projection_matrix(*plane), pseudo)
    assert tr.is_same_transform(flat, tr.projection_matrix(*plane, perspective=eye))
    assert tr.is_same_transform(tr.projection_matrix(*tr.projection_from_matrix(pseudo, pseudo=True)), pseudo)


@pytest.mark.parametrize("name", ["reflection", "rotation", "scale", "shear", "projection"])
def test_what_a_matrix_does_not(name: str) -> None:
    matrix = tr.compose_matrix([1, 2, 3], [0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [1, 2, 3])
    with pytest.raises(ValueError, match="the matrix"):
        getattr(tr, f"{name}_from_matrix")(matrix)


def test_points_are_brought_onto_others() -> None:
    move = tr.concatenate_matrices(tr.translation_matrix([1, 2, 3]), tr.rotation_matrix(2.0, [1, 1, 0]))
    points = [[0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 3.0, 1.0], [1.0, 0.0, 0.0, -1.0], [1.0] * 4]
    moved = [[dot(row, point) for point in zip(*points, strict=True)] for row in move]
    assert tr.is_same_transform(tr.superimposition_matrix(points, moved), move)
    wide = [[2 * x for x in row] for row in points[:3]]
    assert tr.is_same_transform(tr.superimposition_matrix(points, wide, scaling=True), tr.scale_matrix(2.0))
    with pytest.raises(ValueError, match="three rows"):
        tr.superimposition_matrix([[1], [2]], points)


def test_codes_of_axes() -> None:
    for code, axes in {(0, 0, 0, 0): "sxyz", (0, 0, 0, 1): "rzyx", (0, 1, 1, 0): "sxzx", (1, 0, 0, 1): "rxzy"}.items():
        assert tr.euler_matrix(0.1, 0.2, 0.3, code) == tr.euler_matrix(0.1, 0.2, 0.3, axes)


def test_lengths_of_rows_and_columns() -> None:
    rows = [[3.0, 0.0], [4.0, 2.0]]
    assert tr.vector_norm(rows, axis=0) == [5.0, 2.0]
    assert tr.vector_norm([[3.0, 4.0], [0.0, 12.0]]) == 13.0
    assert tr.unit_vector([[3.0, 4.0], [0.0, 2.0]], axis=1) == [[0.6, 0.8], [0.0, 1.0]]
    assert tr.unit_vector(rows, axis=0) == [[0.6, 0.0], [0.8, 1.0]]


def test_a_ball_follows_the_mouse() -> None:
    ball = tr.Arcball()
    ball.place([100, 100], 100)
    ball.down([100, 100])
    ball.drag([200, 100])
    assert [row[2] for row in ball.matrix()[:3]] == pytest.approx([0, 0, -1]), "a ball turns twice as far"
    ball.setaxes([1, 0, 0], [0, 1, 0])
    ball.setconstrain(True)
    assert ball.getconstrain()
    with pytest.raises(ValueError, match="the ball's rotation"):
        tr.Arcball([1, 2, 3])
