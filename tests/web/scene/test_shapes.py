"""Messages as shapes."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.msgs.geometry_msgs.msg import PoseStamped
from pyros1.msgs.nav_msgs.msg import OccupancyGrid, Path
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2, PointField
from pyros1.web.scene import shapes
from pyros1.web.scene.shapes import SHAPES, ShapeError

XYZ = [PointField("x", 0, 7, 1), PointField("y", 4, 7, 1), PointField("z", 8, 7, 1)]


def cloud(count: int, **more: object) -> PointCloud2:
    data = np.arange(3 * count, dtype=np.float32).tobytes()
    values = {"height": 1, "width": count, "fields": XYZ, "point_step": 12, "row_step": 12 * count, "data": data}
    return PointCloud2(**{**values, **more})  # type: ignore[arg-type]


def test_a_scan_with_holes() -> None:
    facts, blob = shapes.laser_scan(LaserScan(angle_min=-1.0, angle_increment=0.5, ranges=[1.0, float("inf")]))
    assert (facts["count"], facts["intensities"]) == (2, False)
    assert struct.unpack("<2f", blob) == (1.0, float("inf"))
    facts, blob = shapes.laser_scan(LaserScan(ranges=[1.0, 2.0], intensities=[3.0, 4.0]))
    assert struct.unpack("<4f", blob) == (1.0, 2.0, 3.0, 4.0)


def test_points_are_passed_on() -> None:
    message = cloud(5)
    facts, blob = shapes.point_cloud(message)
    assert (facts["count"], facts["step"], facts["every"]) == (5, 12, 1)
    assert facts["fields"]["z"] == [8, 7, 1]
    assert blob == message.data


def test_padding_between_rows_is_left_out() -> None:
    rows = [np.arange(6, dtype=np.float32) + 10 * row for row in range(3)]
    data = b"".join(row.tobytes() + b"\xff" * 8 for row in rows)
    facts, blob = shapes.point_cloud(cloud(2, height=3, row_step=32, data=data))
    assert facts["count"] == 6
    assert blob == b"".join(row.tobytes() for row in rows)
    assert shapes.point_cloud(cloud(2, height=3, row_step=32, data=data[:-8]))[1] == blob  # the last row without it


def test_of_large_clouds_some_points_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shapes, "MOST_POINTS", 10)
    facts, blob = shapes.point_cloud(cloud(25))
    assert (facts["count"], facts["every"]) == (9, 3)
    assert np.frombuffer(blob, np.float32)[::3].tolist() == [9.0 * number for number in range(9)]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"fields": XYZ[:2]}, "without x, y and z"),
        ({"fields": []}, "no fields"),
        ({"point_step": 0}, "do not fit"),
        ({"point_step": 8}, "ends behind its point"),
        ({"data": b"123"}, "do not fit"),
        ({"width": 4_000_000_000}, "do not fit"),
        ({"height": 4_000_000_000}, "do not fit"),
    ],
)
def test_clouds_that_contradict_themselves(more: dict[str, object], said: str) -> None:
    with pytest.raises(ShapeError, match=said):
        shapes.point_cloud(cloud(5, **more))


def test_maps() -> None:
    message = OccupancyGrid(data=[-1, 0, 100, 50, 0, 0])
    message.info.width, message.info.height, message.info.resolution = 3, 2, 0.05
    facts, blob = shapes.occupancy_grid(message)
    assert (facts["width"], facts["height"]) == (3, 2)
    assert struct.unpack("<6b", blob) == (-1, 0, 100, 50, 0, 0)
    message.info.width = 4
    with pytest.raises(ShapeError, match="has 6 values"):
        shapes.occupancy_grid(message)


@given(st.lists(st.tuples(*[st.floats()] * 7), max_size=20))
def test_any_path(poses: list[tuple[float, ...]]) -> None:
    message = Path(poses=[PoseStamped() for _ in poses])
    for each, (x, y, z, a, b, c, d) in zip(message.poses, poses, strict=True):
        each.pose.position.x, each.pose.position.y, each.pose.position.z = x, y, z
        turn = each.pose.orientation
        turn.x, turn.y, turn.z, turn.w = a, b, c, d
    facts, blob = shapes.path(message)
    assert (facts["count"], len(blob)) == (len(poses), 28 * len(poses))


@pytest.mark.parametrize("kind", sorted(SHAPES))
def test_default_messages_of_every_type(kind: str) -> None:
    from pyros1.msgs import load_message

    try:
        facts, blob = SHAPES[kind](load_message(kind)())
    except ShapeError:
        assert kind == "sensor_msgs/PointCloud2"
    else:
        json.dumps(facts, allow_nan=False)
        assert isinstance(blob, bytes)
