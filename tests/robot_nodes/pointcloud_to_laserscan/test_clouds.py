from __future__ import annotations

import random
import struct

import numpy as np
import pytest

from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import PointCloud2, PointField
from pyros1.robot_nodes.pointcloud_to_laserscan.clouds import make_cloud, read_positions

CODES = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 8: "d"}


@pytest.mark.parametrize("seed", range(24))
def test_clouds_of_any_layout(seed: int) -> None:
    chance = random.Random(seed)
    order = chance.choice("<>")
    names = ["x", "y", "z", "ring"]
    chance.shuffle(names)
    fields, offset = [], chance.randrange(4)
    for name in names:
        datatype = chance.randint(1, 8)
        fields.append(PointField(name=name, offset=offset, datatype=datatype, count=1))
        offset += struct.calcsize(CODES[datatype]) + chance.randrange(3)
    height, width, padding = chance.randrange(4), chance.randrange(5), chance.randrange(4)
    row_step = width * offset + padding
    data = bytearray(chance.randrange(256) for _ in range(row_step * height))
    expected = []
    for row in range(height):
        for column in range(width):
            point = {}
            for field in fields:
                value = chance.randrange(100)
                place = row * row_step + column * offset + field.offset
                struct.pack_into(order + CODES[field.datatype], data, place, value)
                point[field.name] = value
            expected.append([point[name] for name in "xyz"])
    cloud = PointCloud2(
        height=height,
        width=width,
        fields=fields,
        is_bigendian=order == ">",
        point_step=offset,
        row_step=row_step,
        data=bytes(data),
    )
    assert read_positions(cloud).tolist() == expected


def xyz(**changes: object) -> PointCloud2:
    cloud = make_cloud(PointCloud2().header, {name: np.zeros(3, np.float32) for name in "xyz"})
    for name, value in changes.items():
        setattr(cloud, name, value)
    return cloud


@pytest.mark.parametrize(
    ("cloud", "problem"),
    [
        (xyz(data=b""), "0 bytes are too few for 3 x 1 points of 12 bytes"),
        (xyz(width=4), "36 bytes are too few for 4 x 1"),
        (xyz(width=2**32 - 1, height=2**32 - 1), "too few"),
        (xyz(row_step=11, width=1), "too few"),
        (xyz(width=2**32 - 1, height=2**32 - 1, point_step=0, row_step=0), "outside the 0 bytes"),
        (xyz(width=2**31, height=1, point_step=0, row_step=0, data=b""), "outside the 0 bytes"),
        (xyz(fields=[]), "no coordinate x, only nothing"),
        (xyz(fields=[PointField(name="x", datatype=9)]), "no coordinate x, only x"),
        (xyz(fields=[PointField(name="x", offset=9, datatype=7)]), "x is outside the 12 bytes"),
    ],
)
def test_damaged_clouds(cloud: PointCloud2, problem: str) -> None:
    with pytest.raises(MessageError, match=problem):
        read_positions(cloud)


def test_clouds_that_are_made_here() -> None:
    columns = {name: np.arange(3, dtype=np.float32) + shift for shift, name in enumerate("xyz")}
    cloud = make_cloud(PointCloud2().header, {**columns, "index": np.arange(3, dtype=np.int32)})
    assert [(field.name, field.offset, field.datatype) for field in cloud.fields] == [
        ("x", 0, 7),
        ("y", 4, 7),
        ("z", 8, 7),
        ("index", 12, 5),
    ]
    assert (cloud.height, cloud.width, cloud.point_step, cloud.row_step) == (1, 3, 16, 48)
    assert read_positions(cloud).tolist() == [[0, 1, 2], [1, 2, 3], [2, 3, 4]]
