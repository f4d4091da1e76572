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


@pytest.mark.parametrize("seed", range(4))
def test_every_pixel(seed: int) -> None:
    random = np.random.default_rng(seed)
    camera = Camera(width=12, height=10, view=1.2, z=0.4, wall_height=1.0, robot_height=0.6)
    pose = random.uniform(-3, 3, 3)
    distances = random.uniform(0.3, 6, 12)
    distances[random.integers(12)] = inf
    faces_x, are_robots = random.random(12) < 0.5, random.random(12) < 0.3
    picture = draw(camera, pose, distances, faces_x, are_robots)
    focal = 6 / np.tan(0.6)
    for column in range(12):
        angle = np.arctan((5.5 - column) / focal)
        way = distances[column]
        hit_x, hit_y = pose[0] + way * np.cos(pose[2] + angle), pose[1] + way * np.sin(pose[2] + angle)
        height = 0.6 if are_robots[column] else 1.0
        for row in range(10):
            up = 0.4 + (4.5 - row) / focal * way * np.cos(angle)  # how high one looks, where the ray ends
            if way == inf or not 0 <= up <= height:
                expected = (206, 214, 224) if row < 4.5 else (112, 104, 96)
            else:
                if are_robots[column]:
                    colour = (217, 71, 15)
                elif faces_x[column]:
                    colour = tuple((0.82 if int(np.floor(hit_y * 2)) % 2 == 0 else 1) * c for c in (196, 186, 164))
                else:
                    colour = tuple((0.82 if int(np.floor(hit_x * 2)) % 2 == 0 else 1) * c for c in (166, 156, 138))
                expected = tuple(part / (1 + way / 12) for part in colour)
            assert picture[row, column] == pytest.approx(expected, abs=1.0), (row, column)


def test_touching_a_wall() -> None:
    flags = np.ones(61, np.bool_)
    assert draw(CAMERA, POSE, np.zeros(61), flags, ~flags).shape == (81, 61, 3)


def test_left_is_left() -> None:
    assert CAMERA.angles[0] > 0 > CAMERA.angles[-1]
    assert CAMERA.angles[0] == pytest.approx(-CAMERA.angles[-1])
