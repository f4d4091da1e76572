"""Encode and decode times of pyros1's message codecs beside genpy's, in one process.

Run with the Python that has the stock message packages::

    PYTHONPATH=src /usr/bin/python3 interop/bench/codec.py

Prints nanoseconds per message (best of several rounds, both taking turns) and genpy's time divided by ours: above 1
means that ours is faster. "make default" constructs a message without arguments. ``--side ours`` or ``stock`` measures
one only, and prints its figures as JSON.
"""

from __future__ import annotations

import argparse
import importlib
import io
import json
import sys
import timeit
from collections.abc import Callable
from typing import Any

from pyros1.ground.timing import Time
from pyros1.msgs import load_message

ROUNDS = 9


def fill_header(message: Any) -> None:
    message.header.seq = 12345
    message.header.stamp = Time(1700000000, 123456789)
    message.header.frame_id = "base_link"


def twist(message: Any) -> None:
    message.linear.x, message.linear.y, message.angular.z = 1.0, 2.0, 3.0


def joint_state(message: Any) -> None:
    fill_header(message)
    message.name = [f"joint_{i}" for i in range(7)]
    message.position = [0.1 * i for i in range(7)]
    message.velocity = [0.2 * i for i in range(7)]
    message.effort = [0.3 * i for i in range(7)]


def point_cloud(message: Any) -> None:
    fill_header(message)
    message.height, message.width, message.point_step, message.row_step = 1, 65536, 16, 1 << 20
    message.fields = [type_of_field(message)(n, 4 * i, 7, 1) for i, n in enumerate("xyz")]
    message.data = bytes(1 << 20)


def type_of_field(message: Any) -> Any:
    package = type(message).__module__.rpartition(".msg")[0]
    return importlib.import_module(package + ".msg").PointField


def laser_scan(message: Any) -> None:
    fill_header(message)
    message.ranges = tuple(0.01 * i for i in range(720))
    message.intensities = tuple(0.5 * i for i in range(720))


def transforms(message: Any) -> None:
    package = (
        "geometry_msgs.msg" if not type(message).__module__.startswith("pyros1") else "pyros1.msgs.geometry_msgs.msg"
    )
    stamped = importlib.import_module(package).TransformStamped
    message.transforms = [stamped() for _ in range(10)]
    for transform in message.transforms:
        fill_header(transform)
        transform.child_frame_id = "tool"
        transform.transform.rotation.w = 1.0


def nothing(message: Any) -> None:
    pass


CASES: list[tuple[str, str, Callable[[Any], None]]] = [
    ("std_msgs/Float64", "Float64", nothing),
    ("std_msgs/String", "String", lambda m: setattr(m, "data", "hello world")),
    ("geometry_msgs/Twist", "Twist", twist),
    ("geometry_msgs/PoseStamped", "PoseStamped", fill_header),
    ("sensor_msgs/Imu", "Imu", fill_header),
    ("sensor_msgs/JointState", "JointState(7)", joint_state),
    ("nav_msgs/Odometry", "Odometry", fill_header),
    ("sensor_msgs/LaserScan", "LaserScan(720)", laser_scan),
    ("tf2_msgs/TFMessage", "TFMessage(10)", transforms),
    ("sensor_msgs/PointCloud2", "PointCloud2(1 MB)", point_cloud),
]


LABELS = [label for _, label, _ in CASES]
SIDES = ("stock", "ours")
WORKS = ("encode", "decode", "make default")


def time_each(*functions: Callable[[], Any]) -> list[float]:
    """Return each function's best time per call in ns; the functions take turns."""
    number = max(1, int(0.02 / max(timeit.timeit(functions[0], number=100) / 100, 1e-9)))
    best = [float("inf")] * len(functions)
    for _ in range(ROUNDS):
        for i, function in enumerate(functions):
            best[i] = min(best[i], timeit.timeit(function, number=number) / number * 1e9)
    return best


def functions_of(type_name: str, prepare: Callable[[Any], None]) -> dict[str, dict[str, Callable[[], Any]]]:
    """What is timed, by work and side."""
    package, _, short = type_name.partition("/")
    stock = getattr(importlib.import_module(package + ".msg"), short)
    ours = load_message(type_name)
    theirs, mine = stock(), ours()
    prepare(theirs)
    prepare(mine)
    buffer = io.BytesIO()

    def stock_encode() -> None:
        buffer.seek(4)  # as rospy does: room for the length, which is written afterwards
        theirs.serialize(buffer)

    encode, decode = ours._encode_frame, ours._decode
    frame = encode(mine)
    data = (frame if isinstance(frame, bytes) else b"".join(frame))[4:]
    stock_encode()
    if buffer.getvalue()[4:] != data:
        raise SystemExit(f"{type_name}: the two encodings differ")
    size = len(data)
    return {
        "encode": {"stock": stock_encode, "ours": lambda: encode(mine)},
        "decode": {"stock": lambda: stock().deserialize(data), "ours": lambda: decode(data, 0, size)},
        "make default": {"stock": stock, "ours": ours},
    }


def one_side(side: str) -> dict[str, float]:
    """The figures of one side, by work and label."""
    figures = {}
    for type_name, label, prepare in CASES:
        functions = functions_of(type_name, prepare)
        figures.update({f"{work} {label}": time_each(functions[work][side])[0] for work in WORKS})
    return figures


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", choices=SIDES, help="measure only this one")
    side = parser.parse_args().side
    if side:
        print(json.dumps(one_side(side)))
        return 0
    print(f"Python {sys.version.split()[0]}, ns per message: genpy / pyros1 (ratio)")
    print(f"{'':20}" + "".join(f"{work:>30}" for work in WORKS))
    worst = float("inf")
    for type_name, label, prepare in CASES:
        functions, cells = functions_of(type_name, prepare), []
        for work in WORKS:
            stock_ns, ours_ns = time_each(*(functions[work][one] for one in SIDES))
            cells.append(f"{stock_ns:.0f} / {ours_ns:.0f} ({stock_ns / ours_ns:.1f}x)")
            worst = min(worst, stock_ns / ours_ns if work != "make default" else worst)
        print(f"{label:20}{''.join(f'{cell:>30}' for cell in cells)}")
    print(f"lowest ratio of encode and decode: {worst:.2f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
