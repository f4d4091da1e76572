"""Rotations as tuples, beside rotation matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.shared.quaternions import (
    conjugate,
    from_rotation_vector,
    from_rows,
    normalized,
    product,
    rotate,
)
from pyros1.tf.rotation import Vector

from ..imu_motion import exponential, matrix

angles = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


@given(angles, angles, st.tuples(*[st.floats(-100, 100)] * 3))
def test_rotations_are_those_of_matrices(first: Vector, second: Vector, vector: Vector) -> None:
    a, b = from_rotation_vector(*first), from_rotation_vector(*second)
    expected = exponential(np.array(first))
    np.testing.assert_allclose(matrix(a), expected, atol=1e-12)
    np.testing.assert_allclose(matrix(product(a, b)), expected @ exponential(np.array(second)), atol=1e-12)
    np.testing.assert_allclose(matrix(conjugate(a)), expected.T, atol=1e-12)
    np.testing.assert_allclose(rotate(a, vector), expected @ vector, atol=1e-10)


@given(angles)
def test_a_matrix_becomes_a_quaternion(rotation: Vector) -> None:
    rows = exponential(np.array(rotation))
    x, y, z = (tuple(row) for row in rows.tolist())
    np.testing.assert_allclose(matrix(from_rows(x, y, z)), rows, atol=1e-9)


@pytest.mark.parametrize("rotation", [(np.pi, 0, 0), (0, np.pi, 0), (0, 0, np.pi), (0, 0, 0)])
def test_half_turns_become_quaternions(rotation: Vector) -> None:
    rows = exponential(np.array(rotation))
    x, y, z = (tuple(row) for row in rows.tolist())
    np.testing.assert_allclose(matrix(from_rows(x, y, z)), rows, atol=1e-12)


def test_normalized_has_unit_length() -> None:
    assert normalized((0.0, 3.0, 0.0, -4.0)) == pytest.approx((0.0, 0.6, 0.0, -0.8))
