"""Clouds as blocks of numbers for a graphics card."""

from __future__ import annotations

import json
import math
import tracemalloc
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.msgs.geometry_msgs.msg import Point32
from pyros1.msgs.sensor_msgs.msg import ChannelFloat32, PointCloud, PointCloud2, PointField
from pyros1.web.scene import clouds
from pyros1.web.scene.shape import ShapeError

XYZ = [PointField("x", 0, 7, 1), PointField("y", 4, 7, 1), PointField("z", 8, 7, 1)]


def cloud(count: int, **more: object) -> PointCloud2:
    data = np.arange(3 * count, dtype=np.float32).tobytes()
    values = {"height": 1, "width": count, "fields": XYZ, "point_step": 12, "row_step": 12 * count, "data": data}
    return PointCloud2(**{**values, **more})  # type: ignore[arg-type]


def points(rows: list[tuple[Any, ...]], kinds: str, extra: list[PointField], **more: object) -> PointCloud2:
    data = np.array(rows, np.dtype(kinds)).tobytes()
    step = len(data) // len(rows)
    return cloud(len(rows), fields=[*XYZ, *extra], point_step=step, row_step=step * len(rows), data=data, **more)


def test_places_are_passed_on_and_coloured_by_height() -> None:
    facts, blob = clouds.point_cloud2(cloud(5))
    assert (facts["count"], facts["every"], facts["fields"]) == (5, 1, ["x", "y", "z"])
    assert (facts["colour"], facts["by"]) == ("z", "z")
    assert blob == cloud(5).data


def test_a_field_of_ones_choice_colours_with_a_byte_for_each_point() -> None:
    message = points(
        [(0, 0, 0, 10), (0, 0, 1, 20), (0, 0, 2, 30)], "<f4,<f4,<f4,<u2", [PointField("intensity", 12, 4, 1)]
    )
    facts, blob = clouds.point_cloud2(message)
    assert (facts["colour"], facts["by"], facts["least"], facts["most"]) == ("value", "intensity", 10.0, 30.0)
    assert blob[36:] == bytes([0, 127, 255])
    facts, blob = clouds.point_cloud2(message, "x")
    assert (facts["by"], facts["colour"], blob[36:]) == ("x", "x", b"")  # the page knows where they are
    assert clouds.point_cloud2(message, "nothing")[0]["by"] == "intensity"


def test_values_are_between_bounds_of_ones_choice() -> None:
    rows = [(0, 0, 0, value) for value in (-5, 10, 20, 30, float("nan"))]
    message = points(rows, "<f4,<f4,<f4,<f4", [PointField("heat", 12, 7, 1)])
    facts, blob = clouds.point_cloud2(message, "heat", bounds=(0.0, 20.0))
    assert (facts["least"], facts["most"]) == (0.0, 20.0)
    assert blob[60:] == bytes([0, 127, 255, 255, 0])
    channel = ChannelFloat32("heat", [-5.0, 10.0, 20.0])
    other = PointCloud(points=[Point32()] * 3, channels=[channel])
    assert clouds.point_cloud(other, "heat", bounds=(0.0, 20.0))[1][36:] == bytes([0, 127, 255])


@pytest.mark.parametrize("order", "<>")
def test_packed_colours_of_either_byte_order(order: str) -> None:
    kinds = f"{order}f4,{order}f4,{order}f4,{order}u4"
    message = points([(1, 2, 3, 0x102030)], kinds, [PointField("rgb", 12, 7, 1)], is_bigendian=order == ">")
    facts, blob = clouds.point_cloud2(message)
    assert (facts["colour"], facts["by"]) == ("rgb", "rgb")
    assert np.frombuffer(blob[:12], np.float32).tolist() == [1, 2, 3]
    assert blob[12:] == b"\x30\x20\x10\x00"


@pytest.mark.parametrize("order", "<>")
def test_colours_with_opacity(order: str) -> None:
    kinds = f"{order}f4,{order}f4,{order}f4,{order}u4"
    message = points([(1, 2, 3, 0x40102030)], kinds, [PointField("rgba", 12, 6, 1)], is_bigendian=order == ">")
    facts, blob = clouds.point_cloud2(message)
    assert (facts["colour"], blob[12:]) == ("rgba", b"\x30\x20\x10\x40")
    facts, blob = clouds.point_cloud2(message, clouds.MONO)
    assert (facts["colour"], blob[12:15]) == ("rgb", bytes([29] * 3))  # 0.299 * 16 + 0.587 * 32 + 0.114 * 48


def test_colours_of_three_fields() -> None:
    fields = [PointField(name, 12 + 4 * index, 7, 1) for index, name in enumerate("rgb")]
    rows = [(0, 0, 0, 1.0, 0.5, 0.0), (0, 0, 0, 9.0, -1.0, float("nan"))]
    facts, blob = clouds.point_cloud2(points(rows, ",".join(["<f4"] * 6), fields))
    assert (facts["by"], facts["colour"], facts["fields"][-1]) == (clouds.RED_GREEN_BLUE, "rgb", clouds.RED_GREEN_BLUE)
    assert blob[24:] == b"\x00\x80\xff\0" + b"\x00\x00\xff\0"
    channels = [ChannelFloat32(name, [value]) for name, value in zip("rgb", (1.0, 0.5, 0.0), strict=True)]
    other = PointCloud(points=[Point32()], channels=channels)
    assert clouds.point_cloud(other, clouds.RED_GREEN_BLUE)[1][12:] == b"\x00\x80\xff\0"


def test_the_channel_of_older_clouds_is_their_intensity() -> None:
    other = PointCloud(points=[Point32()] * 2, channels=[ChannelFloat32("intensities", [1.0, 2.0])])
    facts, blob = clouds.point_cloud(other)
    assert (facts["by"], blob[24:]) == ("intensity", b"\0\xff")


@pytest.mark.parametrize("row_step", [0, 7])
def test_a_row_step_that_is_not_set(row_step: int) -> None:
    assert clouds.point_cloud2(cloud(3, height=2, row_step=row_step, data=bytes(72)))[0]["count"] == 6


def test_bounds_the_other_way_round() -> None:
    message = points([(0, 0, 0, value) for value in (0, 1, 2, 3)], "<f4,<f4,<f4,<f4", [PointField("heat", 12, 7, 1)])
    assert clouds.point_cloud2(message, "heat", bounds=(2.0, 0.0))[1][48:] == bytes([255, 127, 0, 0])


def test_points_without_a_place_are_left_out() -> None:
    nan = float("nan")
    message = points(
        [(nan, 0, 0, 1.0), (1, 2, 3, 2.0), (0, float("inf"), 0, 3.0)], "<f4,<f4,<f4,<f4", [PointField("i", 12, 7, 1)]
    )
    facts, blob = clouds.point_cloud2(message, "i")
    assert (facts["count"], facts["least"], facts["most"]) == (1, 2.0, 2.0)
    assert np.frombuffer(blob[:12], np.float32).tolist() == [1, 2, 3]
    nothing = points([(nan, nan, nan)], "<f4,<f4,<f4", [])
    assert clouds.point_cloud2(nothing)[0]["count"] == 0


def test_padding_between_rows_is_left_out() -> None:
    rows = [np.arange(6, dtype=np.float32) + 10 * row for row in range(3)]
    data = b"".join(row.tobytes() + b"\xff" * 8 for row in rows)
    facts, blob = clouds.point_cloud2(cloud(2, height=3, row_step=32, data=data))
    assert facts["count"] == 6
    assert blob == b"".join(row.tobytes() for row in rows)
    assert clouds.point_cloud2(cloud(2, height=3, row_step=32, data=data[:-8]))[1] == blob  # the last row without it


def test_a_million_rows_of_one_point_cost_what_a_million_points_cost() -> None:
    padded = cloud(1, fields=[PointField(name, 0, 1, 1) for name in "xyz"], point_step=1, row_step=2)
    padded.height, padded.data = 1_000_000, b"\1\2" * 1_000_000
    tracemalloc.start()
    facts, _ = clouds.point_cloud2(padded)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert facts["count"] == 1_000_000
    assert peak < 60_000_000  # an array for each row would take 120


def test_of_large_clouds_some_points_are_left_out() -> None:
    facts, blob = clouds.point_cloud2(cloud(25), max_points=10)
    assert (facts["count"], facts["every"]) == (9, 3)
    assert np.frombuffer(blob, np.float32)[::3].tolist() == [9.0 * number for number in range(9)]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"fields": XYZ[:2]}, "lacks x, y or z"),
        ({"fields": []}, "no fields"),
        ({"fields": [*XYZ[:2], PointField("z", 8, 99, 1)]}, "not of a known numeric type"),
        ({"point_step": 0}, "do not fit"),
        ({"point_step": 8}, "extends beyond its point"),
        ({"data": b"123"}, "do not fit"),
        ({"width": 4_000_000_000}, "do not fit"),
        ({"height": 4_000_000_000}, "do not fit"),
    ],
)
def test_clouds_that_contradict_themselves(more: dict[str, object], said: str) -> None:
    with pytest.raises(ShapeError, match=said):
        clouds.point_cloud2(cloud(5, **more))


@pytest.mark.parametrize("step", [12, 4_000_000_000])
def test_clouds_without_points(step: int) -> None:
    facts, blob = clouds.point_cloud2(cloud(0, point_step=step, height=7))
    assert (facts["count"], blob) == (0, b"")


@pytest.mark.slow
@given(
    st.lists(st.tuples(st.floats(width=32), st.floats(width=32), st.floats(width=32), st.floats(width=32)), max_size=20)
)
def test_any_numbers(rows: list[tuple[float, ...]]) -> None:
    message = points(rows or [(0, 0, 0, 0)], "<f4,<f4,<f4,<f4", [PointField("i", 12, 7, 1)])
    for by in ("", "i", "x"):
        facts, blob = clouds.point_cloud2(message, by)
        json.dumps(facts, allow_nan=False)
        assert len(blob) == facts["count"] * (12 if facts["colour"] in "xyz" else 13)


def test_the_older_type() -> None:
    message = PointCloud(points=[Point32(1, 2, 3), Point32(4, 5, float("nan")), Point32(7, 8, 9)])
    facts, blob = clouds.point_cloud(message)
    assert (facts["count"], facts["by"]) == (2, "z")
    assert np.frombuffer(blob, np.float32).tolist() == [1, 2, 3, 7, 8, 9]
    message.channels = [ChannelFloat32("intensity", [0.0, 1.0, 2.0]), ChannelFloat32("short", [1.0])]
    facts, blob = clouds.point_cloud(message)
    assert (facts["by"], facts["fields"], blob[24:]) == ("intensity", ["x", "y", "z", "intensity"], bytes([0, 255]))
    message.channels = [ChannelFloat32("z", [0.0, math.inf, 2.0])]
    assert clouds.point_cloud(message)[0]["fields"] == ["x", "y", "z"]
    assert clouds.point_cloud(PointCloud())[0]["count"] == 0


def test_which_points_of_the_message_they_are_and_their_values() -> None:
    nan = float("nan")
    message = points(
        [(nan, 0, 0, 1.0), (1, 2, 3, 2.5), (9, 9, 9, 9.0), (9, 9, 9, 9.0), (4, 5, 6, 0.125)],
        "<f4,<f4,<f4,<f4",
        [PointField("i", 12, 7, 1)],
    )
    facts, blob = clouds.point_cloud2(message, "i", max_points=3, with_indices=True)
    assert (facts["count"], facts["every"], facts["numbers"]) == (2, 2, True)
    places, indices, values, levels = blob[:24], blob[24:32], blob[32:40], blob[40:]
    assert np.frombuffer(places, np.float32).tolist() == [9, 9, 9, 4, 5, 6]
    assert np.frombuffer(indices, np.uint32).tolist() == [2, 4]
    assert np.frombuffer(values, np.float32).tolist() == [9.0, 0.125]
    assert levels == bytes([255, 0])
    assert "numbers" not in clouds.point_cloud2(message, "i", max_points=3)[0]
    _, blob = clouds.point_cloud2(message, "z", with_indices=True)
    assert np.frombuffer(blob[48:], np.uint32).tolist() == [1, 2, 3, 4]  # the heights are in the places
    older = PointCloud(points=[Point32(nan, 2, 3), Point32(4, 5, 6)], channels=[ChannelFloat32("heat", [1.5, 2.5])])
    _, blob = clouds.point_cloud(older, "heat", with_indices=True)
    assert np.frombuffer(blob[12:16], np.uint32).tolist() == [1]
    assert np.frombuffer(blob[16:20], np.float32).tolist() == [2.5]
