"""Decodes the videos of theora_image_transport (https://wiki.ros.org/theora_image_transport). Needs PyAV.

PyAV's FFmpeg has a Theora decoder, but no encoder.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from pyros1.ground.errors import Error, MessageError
from pyros1.msgs import from_definition
from pyros1.msgs.sensor_msgs.msg import Image

_DEFINITION = """\
# A packet of an Ogg stream with a Theora video; the first three are its headers.
Header header     # of the image
uint8[] data
int32 b_o_s       # 1 if the stream begins
int32 e_o_s       # 1 if it ends
int64 granulepos  # place in the video
int64 packetno    # counted from the stream's first one
"""
_NUM_HEADERS = 3
_MAX_HEADER_SIZE = 0xFFFF
_MAX_PIXELS = 1 << 26
_IS_HEADER, _IS_DIFFERENCE = 0x80, 0x40
"""Bits of a packet's first byte; frames without the difference bit are key frames."""
_FULL_RANGE = 2
"""FFmpeg's number for colours with the full range of values; theora_image_transport's have it, unlike most videos."""


def packet_class() -> Any:
    """Return the message class, theora_image_transport/Packet."""
    return from_definition("theora_image_transport/Packet", _DEFINITION)


class TheoraDecoder:
    """Decodes the packets of a topic, starting with the first key frame.

    Raises:
        Error: PyAV is not installed.
    """

    def __init__(self) -> None:
        try:
            self._av: Any = import_module("av")
        except ImportError as error:
            raise Error(f"the image transport theora needs PyAV ({error}): pip install 'pyros1[video]'") from None
        self._pending: list[bytes] = []
        self._headers: list[bytes] = []
        self._context: Any = None
        self._has_key_frame = False
        self._last: Any = None

    def decode(self, packet: Any) -> Any | None:
        """Return the sensor_msgs/Image (bgr8) of a packet; None if it is a header, or the key frame is missing.

        Args:
            packet: a theora_image_transport/Packet.

        Raises:
            MessageError: the packet is damaged.
        """
        data = bytes(packet.data)
        if data and data[0] & _IS_HEADER:
            self._receive_header(data)
            return None
        if self._context is None:
            return None
        if not data:  # the image has not changed
            if self._last is not None:
                self._last = Image(packet.header, *_after_header(self._last))
            return self._last
        self._has_key_frame |= not data[0] & _IS_DIFFERENCE
        if not self._has_key_frame:
            return None
        try:
            frames = self._context.decode(self._av.Packet(data))
        except self._av.error.FFmpegError as error:
            self._has_key_frame = False
            raise MessageError(f"a Theora packet cannot be decoded: {error}") from None
        for frame in frames:
            pixels = frame.reformat(
                format="bgr24", src_color_range=_FULL_RANGE, dst_color_range=_FULL_RANGE
            ).to_ndarray()
            height, width = pixels.shape[:2]
            self._last = Image(
                packet.header, height, width, "bgr8", 0, width * 3, np.ascontiguousarray(pixels).tobytes()
            )
        return self._last if frames else None

    def _receive_header(self, data: bytes) -> None:
        """Store a header. Senders repeat the headers for each new subscriber; this does not interrupt the video."""
        kind = data[0] & ~_IS_HEADER
        if data[1:7] != b"theora" or kind >= _NUM_HEADERS or len(data) > _MAX_HEADER_SIZE:
            raise MessageError("a header of the Theora video is damaged")
        self._pending = [*self._pending[:kind], data]
        if len(self._pending) < _NUM_HEADERS or self._pending == self._headers:
            return
        headers = self._pending
        width, height = (16 * int.from_bytes(headers[0][place : place + 2], "big") for place in (10, 12))
        if not 0 < width * height <= _MAX_PIXELS:
            raise MessageError(f"the Theora video has {width}x{height} pixels, of at most {_MAX_PIXELS}")
        self._context = self._last = None
        context = self._av.CodecContext.create("theora", "r")
        context.thread_count = 1
        context.extradata = b"".join(len(each).to_bytes(2, "big") + each for each in headers)
        try:
            context.open()
        except self._av.error.FFmpegError as error:
            raise MessageError(f"the Theora video cannot be decoded: {error}") from None
        self._headers, self._context, self._has_key_frame = headers, context, False


def _after_header(image: Any) -> tuple[Any, ...]:
    return image.height, image.width, image.encoding, image.is_bigendian, image.step, image.data
