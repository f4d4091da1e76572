"""Images republished in other forms.

Feature: compressing and decompressing images -- `pyros1 run image_transport republish compressed in:=camera raw
    out:=camera_raw`; needs Pillow
"""

from __future__ import annotations

import queue
import random
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest

from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.reconfigure import Client
from pyros1.topic_tools.republish import Republisher, main
from pyros1.topic_tools.theora import packet_class

pytest.importorskip("PIL", reason="the extra `images` brings it")

from pyros1.topic_tools.image_encoding import compress, decompress

SIZES = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1, "8UC1": 1, "8UC3": 3, "bayer_rggb8": 1}
SIZES |= {"mono16": 2, "16UC1": 2, "rgb16": 6, "bgr16": 6, "rgba16": 8, "bgra16": 8, "16UC3": 6, "bayer_gbrg16": 2}


def image(encoding: str = "bgr8", width: int = 8, height: int = 6, more: int = 0) -> Image:
    """An image with smooth colours, and unused bytes in each row."""
    size = SIZES[encoding]
    row = bytes((20 * (place % size) + place) % 256 for place in range(width * size)) + bytes(more)
    found = Image(height=height, width=width, encoding=encoding, step=len(row), data=row * height)
    found.header.frame_id = "camera"
    return found


def rows(message: Any) -> list[bytes]:
    size = SIZES[message.encoding] * message.width
    return [bytes(message.data[i * message.step : i * message.step + size]) for i in range(message.height)]


@pytest.mark.parametrize("encoding", SIZES)
@pytest.mark.parametrize("more", [0, 5])
def test_png_loses_nothing(encoding: str, more: int) -> None:
    before = image(encoding, more=more)
    packed = compress(before, "png")
    assert packed.format.startswith(f"{encoding}; png compressed") and packed.header.frame_id == "camera"
    after = decompress(packed)
    assert (after.encoding, after.width, after.height, rows(after)) == (encoding, 8, 6, rows(before))


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8", "mono8", "bgra8"])
def test_jpeg_is_similar(encoding: str) -> None:
    before = image(encoding, 32, 32)
    after = decompress(compress(before, quality=100))
    size = SIZES[encoding]
    pairs = [(a, b) for i, (a, b) in enumerate(zip(before.data, after.data, strict=True)) if size < 4 or i % size != 3]
    assert max(abs(a - b) for a, b in pairs) < 40


@pytest.mark.parametrize("encoding", ["mono16", "rgb16", "bgra16"])
@pytest.mark.parametrize(("width", "height"), [(1, 1), (1, 6), (6, 1)])
def test_sixteen_bits_of_either_byte_order_in_few_pixels(encoding: str, width: int, height: int) -> None:
    before = image(encoding, width, height)
    after = decompress(compress(before, "png"))
    assert (after.encoding, after.is_bigendian, rows(after)) == (encoding, 0, rows(before))
    before.is_bigendian = 1
    turned = decompress(compress(before, "png"))
    assert np.frombuffer(turned.data, "<u2").tolist() == np.frombuffer(before.data, ">u2").tolist()


def test_colours_with_sixteen_bits_become_jpeg_with_eight() -> None:
    found = decompress(compress(image("rgb16", 32, 32), "jpeg", 100))
    assert found.encoding == "bgr8"


@pytest.mark.parametrize(
    ("encoding", "form", "found"),
    [
        ("mono16", "png", "mono16"),
        ("rgb16", "png", "bgr16"),
        ("rgba8", "png", "bgra8"),
        ("mono16", "mono8; png compressed ", "mono16"),
        ("mono8", "16UC1; png compressed ", "mono8"),
        ("16UC1", "16UC1 ; png compressed ", "16UC1"),
    ],
)
def test_the_file_says_what_the_format_does_not(encoding: str, form: str, found: str) -> None:
    packed = compress(image(encoding), "png")
    packed.format = form
    after = decompress(packed)
    assert after.encoding == found and len(after.data) == after.step * after.height


def test_opacity_that_jpeg_lacks_is_full() -> None:
    after = decompress(compress(image("rgba8", 16, 16), "jpeg"))
    assert after.encoding == "rgba8" and set(after.data[3::4]) == {255}


def test_pictures_that_are_not_of_ros() -> None:
    packed = compress(image("rgb8"), "png")
    packed.format = "png"
    after = decompress(packed)
    assert after.encoding == "bgr8" and rows(after) != rows(image("rgb8"))


def test_what_cannot_be_converted() -> None:
    for wrong in (
        Image(encoding="32FC1", width=1, height=1, step=4, data=b"abcd"),
        Image(encoding="8UC2", width=1, height=1, step=2, data=b"ab"),
        Image(encoding="rgb8", width=2, height=2, step=6, data=b"a"),
        Image(encoding="rgb8"),
    ):
        with pytest.raises(MessageError):
            compress(wrong)
    with pytest.raises(MessageError, match="cannot be converted"):
        compress(image("mono16"), "jpeg")
    rng = random.Random(3)
    whole = compress(image(), "png")
    for data in (b"", b"nothing", whole.data[:40], bytes(rng.randrange(256) for _ in range(200))):
        with pytest.raises(MessageError):
            decompress(CompressedImage(format="bgr8; png compressed bgr8", data=data))
    with pytest.raises(MessageError):
        decompress(CompressedImage(format="32FC1; png", data=whole.data))


def test_both_ways(make_node: Any) -> None:
    node = make_node("republisher")
    Republisher(node, "camera", "raw", "camera_small", "compressed")
    Republisher(node, "camera_small", "compressed", "camera_again", "raw")
    seen: queue.Queue[Any] = queue.Queue()
    other = make_node("viewer")
    other.subscribe("camera_again", Image, seen.put)
    packed: queue.Queue[Any] = queue.Queue()
    other.subscribe("camera_small/compressed", CompressedImage, packed.put)
    Client(other, "camera_small/compressed", 10).update({"format": "png", "png_level": 1}, 10)
    camera = other.advertise("camera", Image)
    assert camera.wait_for_subscribers(1, 10.0)
    found = None
    for _ in range(200):  # until all links are there
        camera.publish(image())
        try:
            found = seen.get(timeout=0.1)
            break
        except queue.Empty:
            continue
    assert found is not None and rows(found) == rows(image())
    assert packed.get(timeout=10).format == "bgr8; png compressed bgr8"
    with pytest.raises(ValueError, match="to itself"):
        Republisher(node, "x", "raw", "x", "raw")
    with pytest.raises(ValueError, match="no image transport 'zstd'"):
        Republisher(node, "x", "zstd", "y", "raw")
    with pytest.raises(ValueError, match="theora can only be received"):
        Republisher(node, "x", "raw", "y", "theora")


def test_all_transports_without_a_transport(make_node: Any) -> None:
    """Feature: image_transport republish of depths: `compressedDepth` as PNG and RVL, both ways"""
    node, other = make_node("republisher"), make_node("viewer")
    Republisher(node, "depth", "raw", "out")
    Republisher(node, "out", "compressedDepth", "again", "raw")
    Client(other, "out/compressedDepth", 10).update({"format": "rvl"}, 10)
    Republisher(make_node("other"), "out", "raw", "out")  # what others publish there is not repeated
    raw, again = queue.SimpleQueue[Any](), queue.SimpleQueue[Any]()
    other.subscribe("out", Image, raw.put)
    other.subscribe("again", Image, again.put)
    other.subscribe("out/compressed", CompressedImage, lambda message: None)  # JPEG of depths is refused, no more
    camera = other.advertise("depth", Image)
    depths = np.arange(9_990, 10_010, dtype=np.uint16).reshape(4, 5)
    message = Image(height=4, width=5, encoding="16UC1", step=10, data=depths.tobytes())
    deadline = monotonic() + 20.0
    while raw.empty() or again.empty():
        assert monotonic() < deadline
        camera.publish(message)
        sleep(0.01)
    assert raw.get().data == message.data
    assert np.frombuffer(again.get().data, np.uint16).tolist() == [*range(9_990, 10_001)] + [0] * 9


def test_theora_is_received(make_node: Any) -> None:
    """Feature: image_transport republish from `theora` -- needs `pip install 'pyros1[video]'`"""
    av: Any = pytest.importorskip("av", reason="the extra `video` brings it")
    with av.open(str(Path(__file__).with_name("theora.ogv"))) as container:
        extra = container.streams.video[0].codec_context.extradata
        key_frame = next(bytes(packet) for packet in container.demux())
    headers = []
    while extra:
        size = int.from_bytes(extra[:2], "big")
        headers.append(extra[2 : 2 + size])
        extra = extra[2 + size :]
    node, other = make_node("republisher"), make_node("viewer")
    Republisher(node, "camera", "theora", "seen", "raw")
    seen: queue.Queue[Any] = queue.Queue()
    camera = other.advertise("camera/theora", packet_class())
    assert camera.wait_for_subscribers(1, 20.0)
    for data in [*headers, key_frame]:  # nobody subscribes yet, but the headers are not sent again
        camera.publish(packet_class()(data=data))
    other.subscribe("seen", Image, seen.put)
    found = None
    deadline = monotonic() + 20.0
    while found is None and monotonic() < deadline:
        camera.publish(packet_class()(data=key_frame))
        try:
            found = seen.get(timeout=0.1)
        except queue.Empty:
            continue
    assert found is not None and (found.width, found.height, found.encoding) == (40, 24, "bgr8")


def test_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["republish"]) == 1
    assert capsys.readouterr().err.startswith("Usage: republish in_transport in:=")
