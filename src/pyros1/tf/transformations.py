"""Rotations and homogeneous matrices: the functions of ``tf.transformations``, on lists of floats.

A quaternion is [x, y, z, w], a matrix a list of four rows. Results are new lists; arguments may be any sequences, numpy
arrays included. Angles are radians.

Euler angles are named by four letters: ``s`` (about the axes that stand still) or ``r`` (about the axes that turn with
it), and three axes in the order of rotation. ``sxyz`` is ROS's roll, pitch, yaw; ``rzyx`` the same from yaw to roll.
"""

from __future__ import annotations

from pyros1.tf.arcball import Arcball, arcball_constrain_to_axis, arcball_map_to_sphere, arcball_nearest_axis
from pyros1.tf.decomposition import (
    decompose_matrix,
    projection_from_matrix,
    reflection_from_matrix,
    rotation_from_matrix,
    scale_from_matrix,
    shear_from_matrix,
    superimposition_matrix,
)
from pyros1.tf.matrices import (
    clip_matrix,
    compose_matrix,
    concatenate_matrices,
    inverse_matrix,
    is_same_transform,
    orthogonalization_matrix,
    projection_matrix,
    random_rotation_matrix,
    reflection_matrix,
    rotation_matrix,
    scale_matrix,
    shear_matrix,
    translation_from_matrix,
    translation_matrix,
)
from pyros1.tf.quaternions import (
    euler_from_matrix,
    euler_from_quaternion,
    euler_matrix,
    identity_matrix,
    quaternion_about_axis,
    quaternion_conjugate,
    quaternion_from_euler,
    quaternion_from_matrix,
    quaternion_inverse,
    quaternion_matrix,
    quaternion_multiply,
    quaternion_slerp,
    random_quaternion,
    random_vector,
    unit_vector,
    vector_norm,
)

__all__ = [
    "Arcball",
    "arcball_constrain_to_axis",
    "arcball_map_to_sphere",
    "arcball_nearest_axis",
    "clip_matrix",
    "compose_matrix",
    "concatenate_matrices",
    "decompose_matrix",
    "euler_from_matrix",
    "euler_from_quaternion",
    "euler_matrix",
    "identity_matrix",
    "inverse_matrix",
    "is_same_transform",
    "orthogonalization_matrix",
    "projection_from_matrix",
    "projection_matrix",
    "quaternion_about_axis",
    "quaternion_conjugate",
    "quaternion_from_euler",
    "quaternion_from_matrix",
    "quaternion_inverse",
    "quaternion_matrix",
    "quaternion_multiply",
    "quaternion_slerp",
    "random_quaternion",
    "random_rotation_matrix",
    "random_vector",
    "reflection_from_matrix",
    "reflection_matrix",
    "rotation_from_matrix",
    "rotation_matrix",
    "scale_from_matrix",
    "scale_matrix",
    "shear_from_matrix",
    "shear_matrix",
    "superimposition_matrix",
    "translation_from_matrix",
    "translation_matrix",
    "unit_vector",
    "vector_norm",
]
