"""Fuzzers of what pages, programs and viewers send to the web server, and of pictures."""

from __future__ import annotations

import base64
import contextlib
import json
import struct
from typing import Any

import numpy as np
from PIL import Image

from pyros1.ground.errors import MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.ground.timing import Time
from pyros1.msgs import load_message
from pyros1.observe import png16
from pyros1.observe.image_files import decode
from pyros1.web.foxglove import payloads
from pyros1.web.foxglove.offers import Channel, Offers, Service
from pyros1.web.foxglove.requests import ClientAdvertise, FrameError
from pyros1.web.foxglove.requests import parse as parse_foxglove
from pyros1.web.foxglove.state_machine import StateMachine
from pyros1.web.rosbridge import frames, png, values
from pyros1.web.rosbridge.frame_decoder import FrameDecoder
from pyros1.web.rosbridge.operations import BridgeError, CallService, Publish
from pyros1.web.scene.rviz.file import RvizFileError, read_rviz
from pyros1.web.server import wire
from pyros1.web.transforms.image_size import image_size

from ..bodies import encode
from . import bombs
from .fuzzer import MEGABYTE, Fuzzer, words

_IMU = load_message("sensor_msgs/Imu")
_NOW = Time(5, 6)


def _frames(data: bytes) -> list[str | bytes]:
    """Return the frames of an input, a line each; those that are UTF-8 also as texts."""
    found: list[str | bytes] = []
    for line in data.split(b"\n"):
        with contextlib.suppress(ValueError):
            found.append(line.decode())
        found.append(line)
    return found


def rosbridge(data: bytes) -> None:
    """Take the frames of a client; its messages become messages."""
    intake = FrameDecoder()
    for frame in _frames(data):
        with contextlib.suppress(BridgeError, MessageError):
            taken = intake.decode(frame)
            match taken[1] if taken else None:
                case Publish(message=value):
                    _answered(values.from_client(_IMU, value, _NOW))
                case CallService(args=args):
                    _answered(values.from_args(_IMU, args, _NOW))


def _answered(message: Any) -> None:
    """Send a message back, as JSON and as CBOR."""
    sent = values.decode(_IMU, encode(message))
    json.loads(frames.to_json(sent))
    frames.to_cbor(values.for_cbor(sent))


def cbor(data: bytes) -> None:
    """Write what a robot sends for clients."""
    sent = values.decode(_IMU, data)
    json.loads(frames.to_json(sent))
    frames.to_cbor(values.for_cbor(sent))


def foxglove(data: bytes) -> None:
    """Do what a viewer asks for; its messages become messages."""
    viewer = StateMachine()
    channel = Channel(1, "/a", "std_msgs/Float64", "float64 data\n", "1")
    viewer.update_offers(Offers({"/a": channel}, {"/s": Service(9, "/s", "std_srvs/Empty", "", "")}))
    for frame in _frames(data):
        actions, told = viewer.handle(frame)
        assert sum(map(len, told)) < 2000 and len(actions) <= len(data)
        with contextlib.suppress(FrameError, MessageError):
            found = parse_foxglove(frame)
            if isinstance(found, ClientAdvertise):
                for each in found.channels:
                    payloads.message_class(each)
        if isinstance(frame, bytes):
            for encoding in payloads.ENCODINGS:
                with contextlib.suppress(MessageError):
                    message = payloads.decode(_IMU, encoding, frame, _NOW)
                    with contextlib.suppress(ValueError):  # JSON has no NaN
                        payloads.encode(message, encoding)


def page(data: bytes) -> None:
    """Read the requests of a page."""
    for frame in _frames(data):
        with contextlib.suppress(wire.RequestError):
            wire.parse(frame)


def pictures(data: bytes) -> None:
    """Read the size of a picture, the text in one, and its pixels."""
    size = image_size(data)
    assert size is None or all(0 <= each < 1 << 32 for each in size)
    Image.MAX_IMAGE_PIXELS = None
    with contextlib.suppress(BridgeError):
        assert len(png.unpack(base64.b64encode(data).decode(), 10_000)) <= 20_000
    with contextlib.suppress(MessageError):
        assert decode(data, 10_000).size <= 40_000


_JSON = words(
    r"""
    {  }  [  ]  ,  :  "  null  true  1e999  NaN  -0  "\\ud800"  \n
    9999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999
    """
)
_OPS = words(
    r"""
    "op"  "id"  "topic"  "msg"  "publish"  "subscribe"  "advertise"  "call_service"  "fragment"  "png"  "data"
    "num"  "total"  "type"  "args"  "service"  "compression"  "subscriptions"  "channels"  "channelId"  "schema"
    "schemaName"  "encoding"  "call"  "open"  "change"  "next"  "close"  "stream"  "parameterNames"  "ros1"
    """
)
_MESSAGE = {"header": {"stamp": {"secs": 1, "nsecs": 2}, "frame_id": "a"}, "orientation_covariance": [None] * 9}


_DEEP = [bombs.nested(b"[", b"]"), bombs.nested(b'{"a":', b"}", b"1"), b'{"op":' + b"9" * 100_000 + b"}"]


def _rosbridge() -> list[bytes]:
    publish = json.dumps({"op": "publish", "topic": "/t", "msg": _MESSAGE})
    parts = [*frames.split(frames.compress(publish, "png"), 100, "p")]
    call = {"op": "call_service", "id": 7, "service": "/s", "args": [1, 2]}
    subscribe = {"op": "subscribe", "topic": "/t", "throttle_rate": 5, "queue_length": 1, "compression": "cbor"}
    texts = (publish, "\n".join(parts), json.dumps(call), json.dumps(subscribe))
    deep = bombs.nested(b"[", b"]", before=b'{"op":"publish","topic":"/t","msg":{"header":', after=b"}}")
    return [*(each.encode() for each in texts), deep, *_DEEP]


def _foxglove() -> list[bytes]:
    channel = {"id": 1, "topic": "/b", "encoding": "json", "schemaName": "p/T", "schema": "int8 a"}
    texts = [
        {"op": "advertise", "channels": [channel]},
        {"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]},
        {"op": "setParameters", "parameters": [{"name": "/p", "value": [1, "x"]}], "id": "a"},
        {"op": "getParameters", "parameterNames": ["/p"]},
        {"op": "fetchAsset", "uri": "package://a/b", "requestId": 1},
    ]
    call = b"\2" + struct.pack("<III", 9, 1, 4) + b"ros1"
    return [*(json.dumps(each).encode() for each in texts), *_DEEP, call, b"\1\1\0\0\0" + json.dumps(_MESSAGE).encode()]


def _pictures() -> list[bytes]:
    packed = base64.b64decode(png.pack("[1,2,3]" * 20))
    deep = png16.write(np.arange(60, dtype=np.uint16).reshape(4, 5, 3))
    jpeg = b"\xff\xd8\xff\xe0\0\4ab\xff\xc0\0\x0b\x08\0\x10\0\x20\x03"
    webp = [b"RIFF\0\0\0\0WEBPVP8" + kind + bytes(20) for kind in (b" ", b"L", b"X")]
    return [packed, deep, jpeg, *webp, b"GIF89a\1\0\1\0", b"BM" + bytes(30)]


def rviz(data: bytes) -> None:
    """Read a file of rviz's displays; a page gets what is in it, and a terminal what is not here."""
    settings, notes = read_rviz(data.decode(errors="replace"), lambda name: f"/{name}")
    assert len(json.dumps(settings, allow_nan=False)) < 100_000 + 10 * len(data)
    assert all(one_line(note, len(note)) == note for note in notes)


_RVIZ = words(
    r"""
    Class:\x20rviz/  Displays:  Group  Topic:\x20/a  Value:\x20true  Color:\x200;\x201;\x202  Views:  Current:  Tools:
    Alpha:\x20.nan  Panels:  Offset:  Namespaces:  {  }  [  ]  ,  &a\x20  *a  \n  -\x20  :\x20  1e999  ~
    """
)
_DISPLAYS = b"""Visualization Manager:
  Displays:
    - {Class: rviz/LaserScan, Topic: /scan, Color Transformer: FlatColor, Color: 1; 2; 3, Size (Pixels): 3}
    - {Class: rviz/Group, Displays: [{Class: rviz/MarkerArray, Marker Topic: /m, Namespaces: {a: true}}]}
  Views: {Current: {Class: rviz/Orbit, Distance: 3, Pitch: 1, Yaw: 1, Focal Point: {X: 1, Y: 2, Z: 3}}}
"""


FUZZERS = {
    "rosbridge": Fuzzer(rosbridge, (), [*_JSON, *_OPS], _rosbridge),
    "cbor": Fuzzer(cbor, (MessageError,), [b"\xff" * 8, bytes(8), b"\0\0\xf0\x7f"], lambda: [encode(_IMU())]),
    "foxglove": Fuzzer(foxglove, (), [*_JSON, *_OPS, b"\1\1\0\0\0", b"\2"], _foxglove),
    "page": Fuzzer(
        page, (), [*_JSON, *_OPS], lambda: [b'{"call":"x","id":1,"args":{}}', b'{"open":"y","stream":2}', *_DEEP]
    ),
    "pictures": Fuzzer(
        pictures, (), [b"\xff", b"IHDR", b"IDAT", b"IEND", b"\x08\x02", bytes(4)], _pictures, memory=8 * MEGABYTE
    ),
    "rviz": Fuzzer(rviz, (RvizFileError,), _RVIZ, lambda: [_DISPLAYS, *bombs.yaml()], memory=64 * MEGABYTE),
}
