"""Converted messages: their types, and what other decoders make of them."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pillow
from tests.bodies import decode, encode

from pyros1.bridge.conversions.conversion import Conversion
from pyros1.bridge.conversions.converters import Converter, check_installed, converted_type, with_conversions
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.rules.parsing import parse_config
from pyros1.ground.errors import Error, MessageError
from pyros1.msgs import load_message
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image, LaserScan
from pyros1.msgs.std_msgs.msg import Header

JPEG, PNG = Conversion("jpeg", 80.0), Conversion("png", 0.0)
EVERY, VOXEL, H264 = Conversion("every", 2.0), Conversion("voxel", 0.1), Conversion("h264", 1e6)


def image(encoding: str, pixels: Any) -> Any:
    data = pixels.tobytes()
    height, width = pixels.shape[:2]
    return Image(Header(frame_id="camera", seq=7), height, width, encoding, 0, len(data) // height, data)


def converted(conversion: Conversion, message: Any) -> Any:
    body = Converter(conversion, "sensor_msgs/Image").convert("/camera", encode(message), 0.0)
    result = decode(CompressedImage, body)
    assert (result.header.frame_id, result.header.seq) == ("camera", 7)
    return result


def ramp(channels: int = 3, dtype: Any = np.uint8) -> Any:
    y, x = np.mgrid[0:48, 0:64]
    return np.dstack([x * 4, y * 5, x + y][:channels]).astype(dtype)


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8"])
def test_colours_as_jpeg(encoding: str) -> None:
    pixels = ramp()
    result = converted(JPEG, image(encoding, pixels))
    assert result.format == f"{encoding}; jpeg compressed bgr8"
    picture = Pillow.open(io.BytesIO(result.data))
    seen = np.asarray(picture)[:, :, :: 1 if encoding == "rgb8" else -1]
    assert picture.format == "JPEG" and np.abs(seen.astype(int) - pixels).mean() < 4


@pytest.mark.parametrize(("encoding", "maximum"), [("mono8", 3), ("bayer_rggb8", 3)])
def test_one_channel_as_jpeg(encoding: str, maximum: int) -> None:
    pixels = ramp(1)[:, :, 0]
    result = converted(JPEG, image(encoding, pixels))
    assert result.format == f"{encoding}; jpeg compressed "
    assert np.abs(np.asarray(Pillow.open(io.BytesIO(result.data))).astype(int) - pixels).mean() < maximum


def test_the_quality_counts() -> None:
    given = image("rgb8", np.random.default_rng(1).integers(0, 255, (48, 64, 3), np.uint8))
    sizes = [len(converted(Conversion("jpeg", quality), given).data) for quality in (10.0, 50.0, 95.0)]
    assert sizes[0] < sizes[1] < sizes[2]


@pytest.mark.parametrize("encoding", ["16UC1", "mono16"])
@pytest.mark.parametrize("conversion", [JPEG, PNG])
def test_depths_as_png(encoding: str, conversion: Conversion) -> None:
    pixels = ramp(1, np.uint16)[:, :, 0] * 300
    result = converted(conversion, image(encoding, pixels.astype("<u2")))
    assert result.format == f"{encoding}; png compressed "
    assert np.array_equal(np.asarray(Pillow.open(io.BytesIO(result.data))), pixels)


def test_colours_as_png() -> None:
    result = converted(PNG, image("rgb8", ramp()))
    picture = Pillow.open(io.BytesIO(result.data))
    assert picture.format == "PNG" and np.array_equal(np.asarray(picture), ramp())


def test_images_that_cannot_be_converted() -> None:
    with pytest.raises(MessageError, match="'32FC1' cannot be compressed"):
        converted(JPEG, image("32FC1", np.zeros((4, 4), np.float32)))
    short = image("rgb8", ramp())
    short.data = short.data[:-1]
    with pytest.raises(MessageError, match="too few for 64x48"):
        converted(JPEG, short)
    with pytest.raises(MessageError):
        Converter(JPEG, "sensor_msgs/Image").convert("/camera", b"nonsense", 0.0)


def test_scans_and_clouds() -> None:
    scan = LaserScan(angle_increment=0.5, ranges=(1.0, 2.0, 3.0))
    body = Converter(EVERY, "sensor_msgs/LaserScan").convert("/laser", encode(scan), 0.0)
    assert decode(LaserScan, body).ranges == (1.0, 3.0)
    cloud: Any = load_message("sensor_msgs/PointCloud2")
    for conversion in (EVERY, VOXEL):
        if conversion is EVERY:
            Converter(conversion, cloud._type).convert("/lidar", encode(cloud()), 0.0)
            continue
        with pytest.raises(MessageError, match="no x"):
            Converter(conversion, cloud._type).convert("/lidar", encode(cloud()), 0.0)


def test_types() -> None:
    compressed: Any = load_message("sensor_msgs/CompressedImage")
    raw = ("sensor_msgs/Image", load_message("sensor_msgs/Image")._md5sum)
    scan: Any = load_message("sensor_msgs/LaserScan")
    for conversion in (JPEG, PNG):
        assert converted_type(conversion, *raw) == (compressed._type, compressed._md5sum, compressed._full_text)
    video = converted_type(H264, *raw)
    assert video is not None and video.name == "foxglove_msgs/CompressedVideo"
    assert converted_type(EVERY, scan._type, scan._md5sum) == (scan._type, scan._md5sum, scan._full_text)
    assert converted_type(VOXEL, scan._type, scan._md5sum) is None
    assert converted_type(JPEG, "sensor_msgs/Image", "0" * 32) is None
    assert converted_type(JPEG, "nowhere_msgs/Image", raw[1]) is None


def test_which_topics_can_be_converted() -> None:
    text = """
send:
- {topic: /camera/**, convert: jpeg}
- {topic: /points, convert: jpeg}
- {topic: 'base:/text', here: /words, convert: every, every: 3}
"""
    rules = parse_config(text, "f", "red").rules
    image_md5, cloud_md5 = (load_message(f"sensor_msgs/{name}")._md5sum for name in ("Image", "PointCloud2"))
    topics = [
        LocalTopic("/camera/image", "sensor_msgs/Image", image_md5, "", False, ("/n",)),
        LocalTopic("/camera/points", "sensor_msgs/PointCloud2", cloud_md5, "", False, ("/n",)),
        LocalTopic("/points", "sensor_msgs/PointCloud2", cloud_md5, "", False, ("/n",)),
        LocalTopic("/words", "std_msgs/String", "1" * 32, "", False, ("/n",)),
    ]
    found, problems = with_conversions(topics, rules)
    assert [[conversion.kind for conversion, _ in topic.convertible] for topic in found] == [
        ["jpeg"],
        ["every"],
        ["every"],
        [],
    ]
    assert problems == {
        "/points": "convert: jpeg is for sensor_msgs/Image, not for sensor_msgs/PointCloud2",
        "/words": "convert: every is for sensor_msgs/PointCloud2 and sensor_msgs/LaserScan, not for std_msgs/String",
    }


def test_packages_that_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    import importlib

    def fail(name: str) -> Any:
        raise ImportError(f"No module named {name}")

    for conversion in (EVERY, VOXEL, JPEG):
        check_installed(conversion)
    for module in ("pyros1.bridge.conversions.video", "pyros1.observe.image_files"):
        monkeypatch.setattr(importlib.import_module(module), "import_module", fail)
    for conversion, extra in ((JPEG, "images"), (PNG, "images"), (H264, "video")):
        with pytest.raises(Error, match=rf"pip install 'pyros1\[{extra}\]'"):
            check_installed(conversion)
