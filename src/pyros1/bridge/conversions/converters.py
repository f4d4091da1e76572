"""Converts the messages of a sent topic: bytes in, bytes out. No I/O.

numpy, Pillow and PyAV are imported with the first converter, so bridges without conversions do not need them.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from pyros1.bridge.conversions.conversion import CLOUD, IMAGE, Conversion, MessageType
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.rules.rules import Rules
from pyros1.ground.errors import Error, MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import load_message

_PNG_LEVEL = 1
"""PNG compression level: higher ones take several times as long, and save a few per cent."""
_Convert = Callable[[str, Any, float], Any]


def converted_type(conversion: Conversion, type_name: str, md5sum: str) -> MessageType | None:
    """Return the type of a topic's messages after a conversion; None if it cannot convert them.

    Args:
        conversion: the conversion.
        type_name, md5sum: the type of the topic's messages.
    """
    if type_name not in conversion.takes or load_message(type_name)._md5sum != md5sum:
        return None
    if conversion.kind in ("jpeg", "png"):
        cls: Any = load_message("sensor_msgs/CompressedImage")
    elif conversion.kind == "h264":
        from pyros1.bridge.conversions.video import video_class  # noqa: PLC0415 - imports numpy

        cls = video_class()
    else:
        cls = load_message(type_name)
    return MessageType(cls._type, cls._md5sum, cls._full_text)


def with_conversions(topics: Iterable[LocalTopic], rules: Rules) -> tuple[list[LocalTopic], dict[str, str]]:
    """Return topics with the conversions that are possible, and why some topics that a rule names cannot be converted.

    Args:
        topics: topics of this site's master.
        rules: the site's rules.
    """
    conversions = {rule.convert for rule in rules.send if rule.convert is not None}
    found, problems = [], {}
    for topic in topics:
        types = ((each, converted_type(each, topic.type, topic.md5sum)) for each in sorted(conversions))
        possible = {conversion: new_type for conversion, new_type in types if new_type is not None}
        found.append(topic._replace(convertible=tuple(possible.items())))
        for rule in rules.send:
            conversion = rule.convert
            if conversion is None or conversion in possible or not rules.names(rule, topic.name):
                continue
            problems[topic.name] = (
                f"convert: {conversion.kind} is for {' and '.join(conversion.takes)}, not for {one_line(topic.type)}"
            )
    return found, problems


def check_installed(conversion: Conversion) -> None:
    """Check that the packages a conversion needs are installed.

    Raises:
        Error: a package is missing; the message says how to install it.
    """
    if conversion.kind in ("jpeg", "png"):
        from pyros1.observe.image_files import import_pillow  # noqa: PLC0415 - imports numpy

        import_pillow()
    elif conversion.kind == "h264":
        Converter(conversion, IMAGE)


class Converter:
    """Converts the messages of one topic. Not thread-safe.

    Args:
        conversion: the conversion.
        type_name: the type of the topic's messages, which the conversion must support.

    Raises:
        Error: a package is not installed.
    """

    def __init__(self, conversion: Conversion, type_name: str) -> None:
        self._class: Any = load_message(type_name)
        self._restart: Callable[[], None] = lambda: None
        self._convert = self._choose(conversion, type_name)

    def _choose(self, conversion: Conversion, type_name: str) -> _Convert:
        kind, value = conversion
        if kind in ("jpeg", "png"):
            return partial(_compress, kind, int(value))
        if kind == "h264":
            from pyros1.bridge.conversions.video import Video  # noqa: PLC0415

            video = Video(value)
            self._restart = video.restart
            return video.convert
        from pyros1.bridge.conversions.points import thin_cloud, thin_scan, voxel_cloud  # noqa: PLC0415

        if kind == "voxel":
            return lambda _, message, __: voxel_cloud(message, value)
        thin = thin_cloud if type_name == CLOUD else thin_scan
        return lambda _, message, __: thin(message, int(value))

    def restart(self) -> None:
        """Make the next message decodable without earlier ones, for new receivers: in video, a key frame."""
        self._restart()

    def convert(self, publisher: str, body: bytes, now: float) -> bytes:
        """Return a converted message.

        Args:
            publisher: the name of its publisher.
            body: the encoded message.
            now: when it arrived, in seconds.

        Raises:
            MessageError: it cannot be converted.
        """
        try:
            converted = self._convert(publisher, self._class().deserialize(body), now)
            buffer = io.BytesIO()
            converted.serialize(buffer)
        except MessageError:
            raise
        except (Error, ValueError, OverflowError, MemoryError) as error:
            raise MessageError(f"{type(error).__name__}: {error}") from None
        return buffer.getvalue()


def _compress(kind: str, quality: int, _: str, image: Any, __: float) -> Any:
    from pyros1.topic_tools.image_encoding import compress, is_deep_grey  # noqa: PLC0415 - imports numpy

    format_name = "png" if kind == "png" or is_deep_grey(image.encoding) else "jpeg"
    return compress(image, format_name, quality, _PNG_LEVEL)
