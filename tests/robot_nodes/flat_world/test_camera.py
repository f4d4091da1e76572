from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest

from pyros1.robot_nodes.flat_world.camera import Camera, draw

CAMERA = Camera(width=61, height=81, view=pi / 2, z=0.5, wall_height=1.5, robot_height=0.25)
POSE = np.zeros(3)


def rows_of_thing(picture: np.ndarray, column: int) -> list[int]:
    """Return the rows in which a column is neither floor nor ceiling."""
    empty = draw(CAMERA, POSE, np.full(61, inf), np.ones(61, np.bool_), np.zeros(61, np.bool_))
    return np.flatnonzero((picture[:, column] != empty[:, column]).any(axis=1)).tolist()


def test_a_wall_ahead_is_as_high_as_it_should_be() -> None:
    distance = 2.0
    ranges = distance / np.cos(CAMERA.angles)
    picture = draw(CAMERA, POSE, ranges, np.ones(61, np.bool_), np.zeros(61, np.bool_))
    assert (picture.shape, picture.dtype) == ((81, 61, 3), np.uint8)
    focal = 30.5  # half the width, since one sees 90 degrees
    assert CAMERA.focal_length == pytest.approx(focal)
    expected = list(range(int(np.ceil(40 - focal * 1.0 / distance)), int(40 + focal * 0.5 / distance) + 1))
    for column in (0, 30, 60):
        assert rows_of_thing(picture, column) == expected


def test_robots_are_lower_than_the_camera() -> None:
    are_robots = np.arange(61) < 30
    picture = draw(CAMERA, POSE, np.full(61, 3.0), np.ones(61, np.bool_), are_robots)
    assert min(rows_of_thing(picture, 10)) > 40 > min(rows_of_thing(picture, 50))
    red, green, blue = picture[max(rows_of_thing(picture, 29)), 29].tolist()
    assert red > 2 * green > 2 * blue


def test_far_walls_are_darker_and_sides_differ() -> None:
    def colour(distance: float, faces_x: bool) -> int:
        faces = np.full(61, faces_x)
        return int(draw(CAMERA, POSE, np.full(61, distance), faces, np.zeros(61, np.bool_))[40, 30].sum())

    assert colour(2.0, True) > colour(8.0, True)
    assert colour(2.2, True) != colour(2.2, False)


def test_stripes_move_when_the_robot_does() -> None:
    ranges, flags = 2.0 / np.cos(CAMERA.angles), np.ones(61, np.bool_)
    still = draw(CAMERA, POSE, ranges, flags, ~flags)
    aside = draw(CAMERA, np.array([0, 0.2, 0]), ranges, flags, ~flags)
    assert not np.array_equal(still, aside)


def test_touching_a_wall() -> None:
    flags = np.ones(61, np.bool_)
    assert draw(CAMERA, POSE, np.zeros(61), flags, ~flags).shape == (81, 61, 3)


def test_left_is_left() -> None:
    assert CAMERA.angles[0] > 0 > CAMERA.angles[-1]
    assert CAMERA.angles[0] == pytest.approx(-CAMERA.angles[-1])
