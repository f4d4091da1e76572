"""Draws what robots' cameras see in a flat world (no I/O)."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, tan

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_FLOOR, _CEILING, _ROBOT = (112, 104, 96), (206, 214, 224), (217, 71, 15)
_WALL_X, _WALL_Y, _STRIPE = (196, 186, 164), (166, 156, 138), 0.82
_STRIPES_PER_METRE = 2.0
_HALF_LIGHT = 12.0
"""Distance in m at which objects are half as bright."""


@dataclass(frozen=True)
class Camera:
    """A camera that looks ahead, without distortion.

    Attributes:
        width, height: size of its images in pixels.
        view: horizontal angle of view in radians.
        x, z: the camera's position on the robot in m.
        wall_height, robot_height: heights of walls and robots in m.
        max_range: the distance up to which the camera sees, in m.
    """

    width: int = 160
    height: int = 120
    view: float = pi / 3
    x: float = 0.05
    z: float = 0.5
    wall_height: float = 1.2
    robot_height: float = 0.45
    max_range: float = 30.0

    @property
    def focal_length(self) -> float:
        """The focal length in pixels."""
        return self.width / 2 / tan(self.view / 2)

    @property
    def angles(self) -> Floats:
        """The direction of each column in radians, positive to the left; shape (width,)."""
        angles: Floats = np.arctan2(self.width / 2 - 0.5 - np.arange(self.width), self.focal_length)
        return angles


def draw(
    camera: Camera, pose: Floats, distances: Floats, faces_x: NDArray[np.bool_], are_robots: NDArray[np.bool_]
) -> NDArray[np.uint8]:
    """Return the image from a robot's camera, as RGB with shape (height, width, 3).

    Args:
        camera: the camera.
        pose: the robot's x and y in m, and its heading in radians.
        distances: the distances from `sensors.cast_rays` for `Camera.angles`, in m; shape (width,).
        faces_x: for each column, whether the side of the wall that it shows faces along x.
        are_robots: for each column, whether it shows a robot.
    """
    angles = camera.angles
    seen = np.where(np.isfinite(distances), distances, camera.max_range)
    depth = np.maximum(seen * np.cos(angles), 1e-3)
    heights = np.where(are_robots, camera.robot_height, camera.wall_height)
    horizon = camera.height / 2 - 0.5
    top = horizon - camera.focal_length * (heights - camera.z) / depth
    bottom = horizon + camera.focal_length * camera.z / depth
    columns = _column_colours(pose[2] + angles, pose, seen, faces_x, are_robots)
    columns /= 1 + (seen / _HALF_LIGHT)[:, None]
    rows = np.arange(camera.height)[:, None]
    background = np.where(rows[:, :, None] < horizon, np.array(_CEILING), np.array(_FLOOR))
    is_thing = (rows >= top) & (rows <= bottom) & np.isfinite(distances)
    return np.where(is_thing[:, :, None], columns[None], background).astype(np.uint8)


def _column_colours(
    directions: Floats, pose: Floats, distances: Floats, faces_x: NDArray[np.bool_], are_robots: NDArray[np.bool_]
) -> Floats:
    """Return RGB with shape (width, 3). Walls have stripes, so that motion along them is visible."""
    along = np.where(faces_x, pose[1] + distances * np.sin(directions), pose[0] + distances * np.cos(directions))
    is_stripe = np.floor(along * _STRIPES_PER_METRE) % 2 == 0
    walls = np.where(faces_x[:, None], np.array(_WALL_X, float), np.array(_WALL_Y, float))
    walls *= np.where(is_stripe, _STRIPE, 1.0)[:, None]
    return np.where(are_robots[:, None], np.array(_ROBOT, float), walls)
