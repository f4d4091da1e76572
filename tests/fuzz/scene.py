"""A fuzzer of what a robot shows in 3D: messages of all types that are drawn, with any numbers."""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from typing import Any

import numpy as np

from pyros1.ground.errors import MessageError
from pyros1.msgs import load_message
from pyros1.web.scene.camera import pinhole_camera
from pyros1.web.scene.depth import colours, depth_cloud, depths
from pyros1.web.scene.grids import Grid
from pyros1.web.scene.interactive import InteractiveMarkers
from pyros1.web.scene.markers import Markers
from pyros1.web.scene.shape import MAX_MAGNITUDE, ShapeError
from pyros1.web.scene.shapes import CLOUD_FUNCTIONS, SHAPE_FUNCTIONS
from pyros1.web.server import wire
from pyros1.web.transforms.frames import Frames
from pyros1.web.views.frames import to_json

from ..bodies import decode, encode
from ..msgs.random_definitions import random_message
from .fuzzer import MEGABYTE, Fuzzer

_CALIBRATED = {"P": [500.0, 0, 2.0, 0, 0, 500.0, 2.0, 0, 0, 0, 1, 0]}


def _markers(array: Any) -> dict[str, Any]:
    markers = Markers()
    markers.apply(array.markers, 5.0)
    return {"new": markers.changes(0, 5.0)[1]}


def _interactive(message: Any) -> dict[str, Any]:
    markers = InteractiveMarkers()
    markers.init(message, 5.0)
    return {"new": markers.changes(0)[1]}


def _frames(message: Any) -> dict[str, Any]:
    frames = Frames()
    frames.add(message.transforms, "/node", False, 5.0)
    return to_json(frames.describe(5.0))


def _picture(message: Any) -> dict[str, Any]:
    with suppress(ShapeError):
        colours(message)
    return depth_cloud(
        depths(message), pinhole_camera(load_message("sensor_msgs/CameraInfo")(**_CALIBRATED)), None, 100
    )[0]


def _grid(message: Any) -> dict[str, Any]:
    grid = Grid()
    grid.put(message)
    taken = grid.take()
    return taken[0] if taken else {}


_OTHERS: dict[str, Callable[[Any], dict[str, Any]]] = {
    "nav_msgs/OccupancyGrid": _grid,
    "sensor_msgs/CameraInfo": lambda message: asdict(pinhole_camera(message)),
    "sensor_msgs/Image": _picture,
    "tf2_msgs/TFMessage": _frames,
    "visualization_msgs/InteractiveMarkerInit": _interactive,
    "visualization_msgs/MarkerArray": _markers,
}
KINDS = sorted({*SHAPE_FUNCTIONS, *_OTHERS})


def scene(data: bytes) -> None:
    """Draw a message; its first byte says of which type."""
    kind = KINDS[data[0] % len(KINDS)] if data else KINDS[0]
    message = decode(load_message(kind), data[1:])
    if kind in _OTHERS:
        wire.push(1, wire.Push(_OTHERS[kind](message)))
        return
    facts, blob = SHAPE_FUNCTIONS[kind](message)
    assert isinstance(wire.push(1, wire.Push(facts, blob)), bytes)
    if facts["kind"] in ("path", "poses", "polygon", "cells"):
        assert (np.abs(np.frombuffer(blob, np.float32)) <= MAX_MAGNITUDE).all()
    if kind in CLOUD_FUNCTIONS:
        assert np.isfinite(np.frombuffer(blob, np.float32, 3 * facts["count"])).all()
    json.dumps(facts)


def _seeds() -> list[bytes]:
    chance = random.Random(5)
    classes = [(bytes([number]), load_message(kind)) for number, kind in enumerate(KINDS)]
    return [first + encode(random_message(chance, cls)) for first, cls in classes for _ in range(3)]


_NUMBERS = [struct.pack("<d", number) for number in (1e300, -1e300, 1e30, 5e-324, float("nan"), float("inf"), 1.0)]
_NUMBERS += [struct.pack("<f", number) for number in (3e38, 1e30, float("nan"), float("-inf"), 1.0)]

FUZZERS = {"scene": Fuzzer(scene, (MessageError, ShapeError), _NUMBERS, _seeds, memory=64 * MEGABYTE)}
