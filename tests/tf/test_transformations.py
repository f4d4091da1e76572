"""Calculations with rotations; beside stock's in interop/tf/test_tf_transformations.py."""

from __future__ import annotations

import subprocess
import sys
from itertools import product
from math import pi
from typing import Any

import numpy as np
import pytest

from pyros1.tf import transformations as tr
from pyros1.tf.rotation import from_angles, to_angles


def same(one: Any, other: Any) -> bool:
    return np.allclose(one, other, atol=1e-12)


def test_roll_pitch_yaw_are_about_the_axes_that_stand_still() -> None:
    quarter = tr.quaternion_from_euler(0, 0, pi / 2)
    assert same(quarter, [0, 0, 0.5**0.5, 0.5**0.5])
    assert same(tr.quaternion_matrix(quarter)[:3, 0], [0, 1, 0]), "x goes to y"
    assert tr.euler_from_quaternion(tr.quaternion_from_euler(0.1, -0.2, 3.0)) == pytest.approx((0.1, -0.2, 3.0))


def test_turning_axes_are_standing_axes_backwards() -> None:
    assert same(tr.quaternion_from_euler(0.1, 0.2, 0.3, "rzyx"), tr.quaternion_from_euler(0.3, 0.2, 0.1, "sxyz"))


@pytest.mark.parametrize("axes", ["", "xyz", "sxxz", "qxyz", "sxyq", "sxyzz", (3, 0, 0, 0)])
def test_axes_that_are_none(axes: Any) -> None:
    for function in (tr.quaternion_from_euler, tr.euler_matrix):
        with pytest.raises(KeyError, match="axes must be"):
            function(0, 0, 0, axes)
    with pytest.raises(KeyError, match="axes must be"):
        tr.euler_from_quaternion([0, 0, 0, 1], axes)


def test_codes_of_axes() -> None:
    for code, axes in {(0, 0, 0, 0): "sxyz", (0, 0, 0, 1): "rzyx", (0, 1, 1, 0): "sxzx", (1, 0, 0, 1): "rxzy"}.items():
        assert same(tr.euler_matrix(0.1, 0.2, 0.3, code), tr.euler_matrix(0.1, 0.2, 0.3, axes))


def test_angles_without_numpy_are_the_same() -> None:
    for angles in product((-3.0, -pi / 2, 0.0, 0.4, pi / 2), repeat=3):
        rotation = from_angles(*angles)
        assert same(rotation, tr.quaternion_from_euler(*angles))
        for length in (1.0, 2.0):
            x, y, z, w = (length * part for part in rotation)
            found = to_angles((x, y, z, w))
            assert same(tr.euler_matrix(*found), tr.quaternion_matrix(rotation))
            assert found == pytest.approx(tr.euler_from_quaternion(rotation))


def test_numpy_is_loaded_for_transformations_only() -> None:
    """A node that looks frames up starts without; so does a static publisher, with its angles."""
    code = "import sys, pyros1.tf as tf; [getattr(tf, name) for name in tf.__all__]; sys.exit('numpy' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_results_are_arrays_of_ones_own() -> None:
    """Programs slice, multiply and change what they get; arguments stay as they are."""
    quaternion, vector = np.array([0.0, 0.0, 0.0, 1.0]), np.array([1.0, 2.0, 3.0])
    matrix = tr.translation_matrix(vector)
    for result in (
        tr.quaternion_conjugate(quaternion),
        tr.quaternion_slerp(quaternion, quaternion, 0.5),
        tr.unit_vector(quaternion),
        tr.translation_from_matrix(matrix),
        tr.concatenate_matrices(matrix),
        tr.decompose_matrix(matrix)[3],
        tr.identity_matrix(),
    ):
        assert (type(result), result.dtype) == (np.ndarray, np.float64)
        result[:] = 9
    assert same(quaternion, [0, 0, 0, 1])
    assert same(matrix[:3, 3], vector)
    assert same(np.dot(matrix, tr.identity_matrix()), tr.translation_matrix([1, 2, 3]))


def test_matrices() -> None:
    move = tr.concatenate_matrices(tr.translation_matrix([1, 2, 3]), tr.rotation_matrix(pi, [0, 0, 2]))
    assert same(tr.translation_from_matrix(move), [1, 2, 3])
    assert tr.is_same_transform(tr.concatenate_matrices(move, tr.inverse_matrix(move)), tr.identity_matrix())
    assert same(tr.quaternion_from_matrix(move), [0, 0, 1, 0])
    with pytest.raises(np.linalg.LinAlgError):
        tr.inverse_matrix(tr.scale_matrix(0.0))


def test_a_direction_of_no_length_is_nan_with_a_warning() -> None:
    for function, arguments in ((tr.unit_vector, [[0, 0, 0]]), (tr.rotation_matrix, [1, [0, 0, 0]])):
        with pytest.warns(RuntimeWarning):
            assert np.isnan(function(*arguments)).any()


def test_random_rotations_have_unit_length() -> None:
    assert tr.vector_norm(tr.random_quaternion()) == pytest.approx(1.0)
    assert tr.is_same_transform(tr.random_rotation_matrix([0, 0.25, 0.5]), tr.quaternion_matrix([1, 0, 0, 0]))
    assert same(tr.quaternion_slerp([0, 0, 0, 1], [0, 0, 0, -1], 0.5), [0, 0, 0, 1])
    state = np.random.get_state()
    try:
        first, again = ((np.random.seed(7), tr.random_quaternion(), tr.random_vector((2, 3)))[1:] for _ in range(2))
    finally:
        np.random.set_state(state)
    assert same(first[0], again[0])
    assert same(first[1], again[1])


def test_a_matrix_is_taken_to_pieces_and_made_again() -> None:
    parts = ([1.5, -2.0, 0.5], [0.1, -0.2, 0.3], [0.4, -0.5, 0.6], [1, 2, 3], [0.01, 0.02, 0.03, 1.0])
    matrix = tr.compose_matrix(*parts)
    assert tr.is_same_transform(tr.compose_matrix(*tr.decompose_matrix(matrix)), matrix)
    assert all(type(part) is float for parts in tr.decompose_matrix(matrix)[1:3] for part in parts)
    with pytest.raises(ValueError, match="singular"):
        tr.decompose_matrix(tr.scale_matrix(0.0))
    with pytest.raises(ValueError, match="last element"):
        tr.decompose_matrix(np.diag([1, 1, 1, 0]))


def test_what_a_matrix_does() -> None:
    axis = [1.0, 2.0, -2.0]
    for angle in (0.3, -0.3, pi, 3.0, 1e-5):
        matrix = tr.rotation_matrix(angle, axis, [4, 5, 6])
        assert tr.is_same_transform(tr.rotation_matrix(*tr.rotation_from_matrix(matrix)), matrix)
    assert tr.rotation_from_matrix(tr.identity_matrix())[0] == 0.0
    plane = tr.reflection_matrix([1, 2, 3], axis)
    assert tr.is_same_transform(tr.reflection_matrix(*tr.reflection_from_matrix(plane)), plane)
    for matrix in (tr.scale_matrix(-3.0, [1, 2, 3]), tr.scale_matrix(2.5, [1, 2, 3], axis), tr.scale_matrix(1.0)):
        assert tr.is_same_transform(tr.scale_matrix(*tr.scale_from_matrix(matrix)), matrix)
    shear = tr.shear_matrix(-0.7, [2, 1, 2], [3, 1, 4], axis)
    assert tr.is_same_transform(tr.shear_matrix(*tr.shear_from_matrix(shear)), shear)


def test_points_are_the_nearest_to_the_origin() -> None:
    """Also where rounding would move them far away: of a matrix that moves, and hardly turns."""
    screw = tr.translation_matrix([0, 0, 5]) @ tr.rotation_matrix(1.0, [0, 0, 1], [3, 4, 9])
    assert same(tr.rotation_from_matrix(screw)[2], [3, 4, 0, 1])
    rounding = tr.rotation_matrix(1e-15, [1, 1, 0])
    assert same(tr.rotation_from_matrix(tr.translation_matrix([1, 2, 3]) @ rounding)[2], [0, 0, 0, 1])
    assert same(tr.reflection_from_matrix(tr.reflection_matrix([3, 4, 5], [0, 0, 2]))[0], [0, 0, 5, 1])


@pytest.mark.parametrize("more", [{}, {"direction": [1, 1, 0]}, {"perspective": [7, 8, -9]}])
@pytest.mark.parametrize("point", [[1, 2, 3], [0, 0, 0]])
def test_projections_are_recognized(point: list[float], more: dict[str, Any]) -> None:
    matrix = tr.projection_matrix(point, [1, 2, -2], **more)
    assert tr.is_same_transform(tr.projection_matrix(*tr.projection_from_matrix(matrix)), matrix)
    assert tr.is_same_transform(tr.concatenate_matrices(matrix, matrix), matrix), "what lies in the plane stays there"


def test_pseudo_projection_keeps_the_depth() -> None:
    plane, eye = ([1, 2, 3], [1, 2, -2]), [7, 8, -9]
    pseudo = tr.projection_matrix(*plane, perspective=eye, pseudo=True)
    flat = tr.concatenate_matrices(tr.projection_matrix(*plane), pseudo)
    assert tr.is_same_transform(flat, tr.projection_matrix(*plane, perspective=eye))
    assert tr.is_same_transform(tr.projection_matrix(*tr.projection_from_matrix(pseudo, pseudo=True)), pseudo)


@pytest.mark.parametrize("name", ["reflection", "rotation", "shear", "projection"])
def test_what_a_matrix_does_not(name: str) -> None:
    for matrix in (tr.compose_matrix([1, 2, 3], [0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [1, 2, 3]), np.zeros((4, 4))):
        with pytest.raises(ValueError, match="the matrix"):
            getattr(tr, f"{name}_from_matrix")(matrix)


@pytest.mark.parametrize("name", ["rotation", "scale", "shear", "projection"])
@pytest.mark.parametrize("wrong", [np.inf, -np.inf, np.nan])
def test_matrices_with_infinite_numbers_are_refused_at_once(name: str, wrong: float) -> None:
    for row, column in np.ndindex(3, 4):
        matrix = np.random.default_rng(1).normal(size=(4, 4))
        matrix[3] = 0, 0, 0, 1
        matrix[row, column] = wrong
        with pytest.raises(ValueError, match="inf"):
            getattr(tr, f"{name}_from_matrix")(matrix)


def test_points_are_brought_onto_others() -> None:
    move = tr.concatenate_matrices(tr.translation_matrix([1, 2, 3]), tr.rotation_matrix(2.0, [1, 1, 0]))
    points = np.array([[0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 3.0, 1.0], [1.0, 0.0, 0.0, -1.0], [1.0] * 4])
    assert tr.is_same_transform(tr.superimposition_matrix(points, move @ points), move)
    assert tr.is_same_transform(tr.superimposition_matrix(points, 2 * points, scaling=True), tr.scale_matrix(2.0))
    with pytest.raises(ValueError, match="three rows"):
        tr.superimposition_matrix([[1], [2]], points)


def test_lengths_of_rows_and_columns() -> None:
    rows = [[3.0, 0.0], [4.0, 2.0]]
    assert type(tr.vector_norm([3.0, 4.0])) is float
    assert same(tr.vector_norm(rows, axis=0), [5.0, 2.0])
    assert same(tr.vector_norm([[3.0, 4.0], [0.0, 12.0]]), [13.0])
    assert same(tr.unit_vector([[3.0, 4.0], [0.0, 2.0]], axis=1), [[0.6, 0.8], [0.0, 1.0]])
    assert same(tr.unit_vector(rows, axis=0), [[0.6, 0.0], [0.8, 1.0]])


def test_an_array_for_the_result() -> None:
    rows, lengths = np.array([[3.0, 4.0], [0.0, 2.0]]), np.empty(2)
    tr.vector_norm(rows, 1, lengths)
    assert same(lengths, [5.0, 2.0])
    tr.unit_vector(rows, 1, out=rows)
    assert same(rows, [[0.6, 0.8], [0.0, 1.0]])


def test_an_arcball_turns_with_the_mouse() -> None:
    ball = tr.Arcball()
    ball.place([100, 100], 100)
    ball.down([100, 100])
    ball.drag([200, 100])
    turned = ball.matrix()[:3, :3]
    assert np.allclose(turned @ (0, 0, 1), (0, 0, -1))  # the angle is twice that between the points
    ball.setconstrain(True)
    ball.down([100, 100])  # without axes, nothing is constrained
    ball.drag([200, 100])
    assert np.allclose(ball.matrix()[:3, :3], turned @ turned)
    ball.setconstrain(False)
    ball.setaxes([0, 0, 1])
    ball.down([100, 100])
    ball.drag([0, 100])
    assert np.allclose(ball.matrix()[:3, :3], turned)
    ball.setconstrain(True)
    assert ball.getconstrain()
    ball.down([150, 100])
    ball.drag([100, 50])
    assert np.allclose(ball.matrix()[:3, :3] @ turned.T, np.diag((-1, -1, 1)))  # half a turn about z
    ball.next()
    assert np.allclose(ball.matrix()[:3, :3], turned)  # and another
    with pytest.raises(ValueError, match="quaternion or matrix"):
        tr.Arcball([1, 2, 3])
