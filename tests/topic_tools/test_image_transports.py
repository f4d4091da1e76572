from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.topic_tools.image_transports import (
    IMAGE_TRANSPORTS,
    compress_depth,
    decompress_depth,
    transport_topic,
)

pytest.importorskip("PIL", reason="the extra `images` brings it")


def depth_image(depths: NDArray[Any], encoding: str, padding: int = 0) -> Any:
    rows = [row.tobytes() + bytes(padding) for row in depths]
    message = Image(height=len(rows), width=depths.shape[1], encoding=encoding, step=len(rows[0]), data=b"".join(rows))
    message.header.frame_id = "camera"
    return message


def depths_of(message: Any) -> NDArray[Any]:
    found = np.frombuffer(message.data, np.float32 if message.encoding == "32FC1" else np.uint16)
    return found.reshape(message.height, message.width)


@pytest.mark.parametrize("format", ["png", "rvl"])
@pytest.mark.parametrize("encoding", ["16UC1", "mono16"])
def test_millimetres(format: str, encoding: str) -> None:
    millimetres = np.random.default_rng(1).integers(0, 12000, (13, 7)).astype(np.uint16)
    packed = compress_depth(depth_image(millimetres, encoding, 3), format)
    assert packed.format == f"{encoding}; compressedDepth {format}" and packed.header.frame_id == "camera"
    found = decompress_depth(packed)
    assert found.encoding == encoding and found.header.frame_id == "camera"
    assert np.array_equal(depths_of(found), np.where(millimetres > 10000, 0, millimetres))
    everything = decompress_depth(compress_depth(depth_image(millimetres, encoding), format, 100.0))
    assert np.array_equal(depths_of(everything), millimetres)


def test_either_byte_order() -> None:
    depths = np.array([[1, 500], [9000, 256]])
    for encoding, kind in (("16UC1", "u2"), ("32FC1", "f4")):
        little, big = (depth_image(depths.astype(order + kind), encoding, 3) for order in "<>")
        big.is_bigendian = 1
        assert compress_depth(big, depth_max=100.0).data == compress_depth(little, depth_max=100.0).data


@pytest.mark.parametrize("format", ["png", "rvl"])
def test_metres(format: str) -> None:
    metres = np.random.default_rng(2).uniform(0.3, 12.0, (13, 7)).astype(np.float32)
    metres[0, :4] = np.nan, np.inf, 0.0, -1.0
    found = depths_of(decompress_depth(compress_depth(depth_image(metres, "32FC1"), format)))
    is_known = (metres > 0.0) & (metres < 10.0)
    assert np.array_equal(np.isnan(found), ~is_known)
    steps = metres**2 / (100.0 * 101.0)  # what one step of the inverse depth is in metres
    assert (np.abs(found - metres) <= steps * 1.1 + 1e-5)[is_known].all()


def test_what_is_no_depth_image() -> None:
    for wrong in (
        Image(encoding="rgb8", width=1, height=1, step=3, data=b"abc"),
        Image(encoding="16UC1", width=2, height=2, step=4, data=b"a"),
        Image(encoding="32FC1"),
    ):
        with pytest.raises(MessageError):
            compress_depth(wrong)
    packed = compress_depth(depth_image(np.ones((4, 4), np.uint16), "16UC1"), "rvl")
    for width in (0, 2**32 - 1, 4097):
        packed.data = packed.data[:12] + width.to_bytes(4, "little") + packed.data[16:]
        with pytest.raises(MessageError):
            decompress_depth(packed)


def test_names() -> None:
    assert transport_topic("/a", "raw") == "/a" and transport_topic("/a", "theora") == "/a/theora"
    assert [name for name, transport in IMAGE_TRANSPORTS.items() if not transport.encode] == ["theora"]
