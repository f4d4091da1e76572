"""Rotations and homogeneous matrices, with numpy: the functions of ``tf.transformations`` (https://wiki.ros.org/tf).

Results are arrays of float64; arguments can be arrays or sequences. A quaternion is [x, y, z, w] (4,), a matrix (4, 4),
a point or direction (3,); further numbers are ignored. Angles are in radians. Undefined results, such as the unit
vector of a vector of length 0, are nan, and numpy issues a warning.

The convention of Euler angles is given by four letters: ``s`` (static axes) or ``r`` (rotating axes), and three axes in
the order of rotation. ``sxyz`` is ROS's roll, pitch, yaw; ``rzyx`` describes the same rotation, with the angles as
yaw, pitch, roll.
"""

from __future__ import annotations

from pyros1.tf.transformations.angles import (
    euler_from_matrix,
    euler_from_quaternion,
    euler_matrix,
    quaternion_from_euler,
)
from pyros1.tf.transformations.arcball import (
    Arcball,
    arcball_constrain_to_axis,
    arcball_map_to_sphere,
    arcball_nearest_axis,
)
from pyros1.tf.transformations.decompose import (
    decompose_matrix,
    projection_from_matrix,
    reflection_from_matrix,
    rotation_from_matrix,
    scale_from_matrix,
    shear_from_matrix,
    translation_from_matrix,
)
from pyros1.tf.transformations.matrices import (
    clip_matrix,
    compose_matrix,
    concatenate_matrices,
    identity_matrix,
    inverse_matrix,
    is_same_transform,
    orthogonalization_matrix,
    projection_matrix,
    random_rotation_matrix,
    reflection_matrix,
    rotation_matrix,
    scale_matrix,
    shear_matrix,
    superimposition_matrix,
    translation_matrix,
)
from pyros1.tf.transformations.quaternions import (
    quaternion_about_axis,
    quaternion_conjugate,
    quaternion_from_matrix,
    quaternion_inverse,
    quaternion_matrix,
    quaternion_multiply,
    quaternion_slerp,
    random_quaternion,
)
from pyros1.tf.transformations.vectors import random_vector, unit_vector, vector_norm

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
