"""Quaternions, angles and rigid transforms beside a calculation with matrices of numpy."""

from __future__ import annotations

import random
from itertools import product as combinations
from math import acos, cos, degrees, pi, sin
from typing import Any

import numpy as np
import pytest

from pyros1.tf import transformations as tr
from pyros1.tf.rotation import (
    IDENTITY,
    Transform,
    from_angles,
    invert,
    multiply,
    multiply_normalized,
    product,
    to_angles,
)

RNG = random.Random(1)
NAMES = [kind + "".join(axes) for kind in "sr" for axes in combinations("xyz", repeat=3)]
CONVENTIONS = [name for name in NAMES if name[1] != name[2] != name[3]]


def numbers(count: int) -> list[float]:
    """Return numbers, none of which is near 0 or another one's negative."""
    return [RNG.choice((-1, 1)) * RNG.uniform(0.2, 2.0) for _ in range(count)]


def unit(values: list[float]) -> list[float]:
    return [float(value) for value in np.array(values) / np.linalg.norm(values)]


def transform() -> Transform:
    """Return a transform with a quaternion of unit length."""
    x, y, z = numbers(3)
    qx, qy, qz, qw = unit(numbers(4))
    return x, y, z, qx, qy, qz, qw


def rotation(quaternion: Any) -> Any:
    """Return the matrix of a unit quaternion: the columns are the axes that v -> q v q* gives."""
    x, y, z, w = quaternion
    left = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])  # q times
    right = np.array([[w, -z, y, -x], [z, w, -x, -y], [-y, x, w, -z], [x, y, z, w]])  # times q*
    return (left @ right)[:3, :3]


def matrix(values: Any) -> Any:
    """Return the matrix (4, 4) of a transform."""
    result = np.identity(4)
    result[:3, :3], result[:3, 3] = rotation(values[3:]), values[:3]
    return result


def turn(axis: str, angle: float) -> Any:
    """Return the matrix of a rotation about an axis."""
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    result = np.identity(3)
    result[j, j] = result[k, k] = cos(angle)
    result[k, j], result[j, k] = sin(angle), -sin(angle)
    return result


def euler(name: str, angles: list[float]) -> Any:
    """Return the matrix of three rotations, about fixed axes in a name with s, about moved axes with r."""
    first, second, third = (turn(axis, angle) for axis, angle in zip(name[1:], angles, strict=True))
    return third @ second @ first if name[0] == "s" else first @ second @ third


@pytest.mark.parametrize("_", range(10))
def test_transforms_are_multiplied_as_matrices(_: int) -> None:
    first, second, third = transform(), transform(), transform()
    assert matrix(multiply(first, second)) == pytest.approx(matrix(first) @ matrix(second))
    assert matrix(multiply_normalized(first, second)) == pytest.approx(matrix(first) @ matrix(second))
    assert product([third, second, first]) == multiply(first, multiply(second, third))
    assert product([first]) == first
    assert matrix(product([third, second, first])) == pytest.approx(matrix(first) @ matrix(second) @ matrix(third))
    assert matrix(invert(first)) == pytest.approx(np.linalg.inv(matrix(first)))
    assert multiply(first, invert(first)) == pytest.approx(IDENTITY) and multiply(IDENTITY, first) == first


@pytest.mark.parametrize("_", range(20))
def test_a_normalized_product_has_the_sign_that_a_matrix_gives(_: int) -> None:
    first, second = transform(), transform()
    factor = RNG.choice((-3.0, 0.5))
    scaled: Any = (*second[:3], *(factor * part for part in second[3:]))
    found = multiply_normalized(first, scaled)
    assert found[3:] == pytest.approx(tr.quaternion_from_matrix(matrix(multiply(first, second))))
    half_turns = [(1.0, 0.0, 0.0, 0.0), (0.0, -1.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.6, -0.8, 0.0, 0.0)]
    expected = [(1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (-0.6, 0.8, 0.0, 0.0)]
    assert [multiply_normalized(IDENTITY, (0.0, 0.0, 0.0, *half))[3:] for half in half_turns] == expected


@pytest.mark.parametrize("_", range(10))
def test_roll_pitch_and_yaw(_: int) -> None:
    roll, pitch, yaw = angles = [RNG.uniform(-pi, pi), RNG.uniform(-1.5, 1.5), RNG.uniform(-pi, pi)]
    quaternion = from_angles(roll, pitch, yaw)
    assert rotation(quaternion) == pytest.approx(euler("sxyz", angles))
    x, y, z, w = (-2.0 * part for part in quaternion)  # any length, any sign
    assert to_angles((x, y, z, w)) == pytest.approx(angles)


@pytest.mark.parametrize("pitch", [pi / 2, -pi / 2])
def test_straight_up_or_down_the_yaw_is_zero(pitch: float) -> None:
    roll, found, yaw = to_angles(from_angles(0.3, pitch, 0.5))
    assert (found, yaw) == (pytest.approx(pitch, abs=1e-7), 0.0)
    assert rotation(from_angles(roll, found, yaw)) == pytest.approx(euler("sxyz", [0.3, pitch, 0.5]), abs=1e-7)


@pytest.mark.parametrize("name", CONVENTIONS)
def test_all_conventions_of_angles(name: str) -> None:
    twice = name[1] == name[3]
    # Where the first axis comes again, the one between them turns forward or, of left-handed axes, backward.
    i, j = ("xyz".index(axis) for axis in (name[1:3] if name[0] == "s" else name[:1:-1]))
    sign = 1 if j == (i + 1) % 3 else -1
    for middle in [sign * angle for angle in (0.3, 1.4, 2.0, 3.0)] if twice else [-1.4, -0.3, 0.3, 1.4]:
        angles = [RNG.uniform(-3, 3), middle, RNG.uniform(-3, 3)]
        expected = euler(name, angles)
        assert rotation(tr.quaternion_from_euler(*angles, name)) == pytest.approx(expected)
        assert tr.euler_matrix(*angles, name)[:3, :3] == pytest.approx(expected)
        assert tr.euler_from_matrix(expected, name) == pytest.approx(angles)
        assert tr.euler_from_quaternion(tr.quaternion_from_euler(*angles, name), name) == pytest.approx(angles)
    # Where two angles turn about the same axis, one is 0; the rotation is the same.
    for middle in (0.0, pi) if twice else (pi / 2, -pi / 2):
        expected = euler(name, [0.4, middle, 0.7])
        angles = [*tr.euler_from_matrix(expected, name)]
        assert euler(name, angles) == pytest.approx(expected, abs=1e-7)
        assert angles[2 if name[0] == "s" else 0] == 0.0 or min(map(abs, angles)) < 1e-7


@pytest.mark.parametrize("_", range(10))
def test_quaternions(_: int) -> None:
    one, other = unit(numbers(4)), unit(numbers(4))
    assert rotation(tr.quaternion_multiply(one, other)) == pytest.approx(rotation(one) @ rotation(other))
    assert multiply((0.0, 0.0, 0.0, *one), (0.0, 0.0, 0.0, *other))[3:] == pytest.approx(  # type: ignore[arg-type]
        tr.quaternion_multiply(one, other)
    )
    scaled = [3.0 * part for part in one]
    assert tr.quaternion_matrix(scaled)[:3, :3] == pytest.approx(rotation(one))
    assert tr.quaternion_multiply(scaled, tr.quaternion_inverse(scaled)) == pytest.approx([0, 0, 0, 1])
    assert tr.quaternion_conjugate(one).tolist() == [-one[0], -one[1], -one[2], one[3]]
    back = tr.quaternion_from_matrix(matrix([0, 0, 0, *one]))
    assert rotation(back) == pytest.approx(rotation(one)) and np.linalg.norm(back) == pytest.approx(1.0)
    assert tr.quaternion_from_matrix(5.0 * matrix([0, 0, 0, *one])) == pytest.approx(back)


@pytest.mark.parametrize("largest", range(4))
def test_the_sign_of_a_matrix_quaternion(largest: int) -> None:
    for sign in (1, -1):
        parts = [0.1, -0.15, 0.2, 0.05]
        parts[largest] = 2.0 * sign
        found = tr.quaternion_from_matrix(matrix([0, 0, 0, *unit(parts)]))
        assert found == pytest.approx([sign * part for part in unit(parts)])


def test_a_rotation_about_an_axis_of_any_length() -> None:
    for axis, letter in (([2, 0, 0], "x"), ([0, 0.5, 0], "y"), ([0, 0, 3], "z")):
        assert rotation(tr.quaternion_about_axis(0.7, axis)) == pytest.approx(turn(letter, 0.7))
    axis = numbers(3)
    assert rotation(tr.quaternion_about_axis(0.7, axis)) @ axis == pytest.approx(axis)
    # Homogeneous vectors have a fourth number.
    assert tr.quaternion_about_axis(0.7, [*axis, 9.0]).tolist() == tr.quaternion_about_axis(0.7, axis).tolist()
    assert tr.quaternion_about_axis(0.7, [0, 0, 0]).tolist() == [0.0, 0.0, 0.0, cos(0.35)]


@pytest.mark.parametrize("_", range(10))
def test_interpolation_turns_evenly(_: int) -> None:
    one, axis, angle = unit(numbers(4)), numbers(3), RNG.uniform(0.1, 3.0)
    last = tr.quaternion_multiply(tr.quaternion_about_axis(angle, axis), one)
    for sign in (1.0, -1.0):
        for fraction in (0.0, 0.25, 0.5, 1.0, 1.5):
            expected = tr.quaternion_multiply(tr.quaternion_about_axis(fraction * angle, axis), one)
            found = tr.quaternion_slerp(one, sign * 2.0 * last, fraction)
            assert rotation(found) == pytest.approx(rotation(expected))
    # The longer way goes backwards, and a spin adds half turns.
    far = tr.quaternion_slerp(one, -last, 0.5, shortestpath=False)
    expected = tr.quaternion_multiply(tr.quaternion_about_axis(angle / 2 - pi, axis), one)
    assert rotation(far) == pytest.approx(rotation(expected))
    spun = tr.quaternion_slerp(one, last, 0.5, spin=2)
    expected = tr.quaternion_multiply(tr.quaternion_about_axis(angle / 2 + 2 * pi, axis), one)
    assert rotation(spun) == pytest.approx(rotation(expected))
    assert tr.quaternion_slerp(one, one, 0.5).tolist() == pytest.approx(one)
    assert tr.quaternion_slerp(one, [-part for part in one], 0.5).tolist() == pytest.approx(one)


def test_a_crystal_cell() -> None:
    lengths, angles = [1.0, 2.0, 3.0], [70.0, 80.0, 100.0]
    a, b, c = tr.orthogonalization_matrix(lengths, angles)[:3, :3].T
    assert [np.linalg.norm(edge) for edge in (a, b, c)] == pytest.approx(lengths)
    cosines = [one @ two / np.linalg.norm(one) / np.linalg.norm(two) for one, two in ((b, c), (a, c), (a, b))]
    assert [degrees(acos(cosine)) for cosine in cosines] == pytest.approx(angles)
    assert np.linalg.det([a, b, c]) > 0


def test_a_matrix_is_composed_step_by_step() -> None:
    scale, shear, angles, move = numbers(3), numbers(3), numbers(3), numbers(3)
    leaning = np.identity(4)
    leaning[0, 1], leaning[0, 2], leaning[1, 2] = shear
    turned = np.identity(4)
    turned[:3, :3] = euler("sxyz", angles)
    expected = tr.translation_matrix(move) @ turned @ leaning @ np.diag([*scale, 1.0])
    assert tr.compose_matrix(scale, shear, angles, move) == pytest.approx(expected)
    more = ([*values, 9.0] for values in (scale, shear, angles, move))
    assert tr.compose_matrix(*more) == pytest.approx(expected)
