"""Each field of the messages that rviz draws is drawn here, or named in the list of displays as one that is not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path as FilePath
from typing import Any

import pytest

from pyros1.ground.timing import Duration, Time
from pyros1.msgs.geometry_msgs.msg import Point, PoseStamped
from pyros1.msgs.nav_msgs.msg import OccupancyGrid, Odometry, Path
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2, PointField
from pyros1.msgs.std_msgs.msg import ColorRGBA
from pyros1.msgs.visualization_msgs.msg import Marker
from pyros1.web.scene.markers import Markers
from pyros1.web.scene.shape import ShapeError
from pyros1.web.scene.shapes import SHAPE_FUNCTIONS

pytestmark = pytest.mark.once

LIST = FilePath(__file__).parents[3] / "src/pyros1/guide/howto/displays.md"
OF_THE_VIEW = {"header.frame_id", "header.stamp"}
"""Where and when a message is: `pyros1.web.views.scene.topic` looks for its place; tests/web/views/test_scene.py."""


def cloud() -> PointCloud2:
    fields = [PointField(name, 4 * index, 7, 1) for index, name in enumerate("xyzi")]
    return PointCloud2(height=2, width=2, fields=fields, point_step=20, row_step=44, data=bytes(range(88)))


def grid() -> OccupancyGrid:
    message = OccupancyGrid(data=[0, 100])
    message.info.width, message.info.height, message.info.resolution = 2, 1, 1.0
    return message


def odometry() -> Odometry:
    message = Odometry()
    message.pose.covariance = [1.0] * 36
    return message


def marker() -> Marker:
    return Marker(ns="a", points=[Point()] * 2, colors=[ColorRGBA()] * 2)


MESSAGES: list[Callable[[], Any]] = [
    marker,
    cloud,
    grid,
    odometry,
    lambda: LaserScan(angle_increment=0.1, range_max=9.0, ranges=[1.0, 2.0], intensities=[3.0, 4.0]),
    lambda: Path(poses=[PoseStamped()]),
]


def drawn(message: Any) -> Any:
    """Return what a page gets of a message; an error is something else, too."""
    if not isinstance(message, Marker):
        try:
            return SHAPE_FUNCTIONS[message._type](message)
        except ShapeError as error:
            return str(error)
    known = Markers()
    known.apply([Marker(ns="a")], 0.0)
    known.apply([message], 1.0)
    return known.changes(0, 2.0)


def fields(message: Any, before: str = "") -> Iterator[tuple[str, Callable[[Any], None]]]:
    """Yield each field's name, and a function that changes it in such a message."""
    for name in message.__slots__:
        value = getattr(message, name)
        path = f"{before}{name}"
        if isinstance(value, (list, tuple)) and value and hasattr(value[0], "__slots__"):
            for inner, change in fields(value[0], f"{path}[]."):
                yield inner, lambda owner, name=name, change=change: change(getattr(owner, name)[0])
        elif hasattr(value, "__slots__") and not isinstance(value, (Time, Duration)):
            for inner, change in fields(value, f"{path}."):
                yield inner, lambda owner, name=name, change=change: change(getattr(owner, name))
        else:
            yield path, lambda owner, name=name: setattr(owner, name, another(getattr(owner, name)))


def another(value: Any) -> Any:
    if isinstance(value, (Time, Duration)):
        return type(value)(0, 500_000)
    if isinstance(value, bool):
        return not value
    if isinstance(value, (int, float)):
        return value + 2
    if isinstance(value, str):
        return value + "b"
    if isinstance(value, bytes):
        return bytes(255 - each for each in value)
    return [each + 2 for each in value]


@pytest.mark.parametrize("make", MESSAGES, ids=lambda make: type(make())._type.replace("/", "."))
def test_each_field_is_drawn_or_named_as_one_that_is_not(make: Callable[[], Any]) -> None:
    listed = LIST.read_text()
    kind = make()._type.partition("/")[2]
    before, ignored = drawn(make()), []
    for name, change in fields(make()):
        message = make()
        change(message)
        if drawn(message) == before and name not in OF_THE_VIEW:
            ignored.append(name)
    assert len(ignored) < len(list(fields(make())))
    forgotten = [name for name in ignored if not any(f"`{part}`" in listed for part in wholes(kind, name))]
    assert not forgotten, forgotten


def wholes(kind: str, name: str) -> Iterator[str]:
    """Yield the ways to list a field: alone, and as a part of others."""
    parts = name.split(".")
    for count in range(1, len(parts) + 1):
        yield f"{kind}.{'.'.join(parts[:count])}"
    yield ".".join(parts[-2:])
