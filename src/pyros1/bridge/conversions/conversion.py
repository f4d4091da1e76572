"""The conversions for sent messages, and how a rule selects them. No I/O.

=========  ==================================  ===============================================================
convert    takes                               sends
=========  ==================================  ===============================================================
``jpeg``   sensor_msgs/Image                   sensor_msgs/CompressedImage on NAME/compressed, as image_transport
                                               does: JPEG, or PNG for grey images with 16 bits, such as depths
``png``    the same                            the same, all as PNG, without loss
``h264``   the same                            foxglove_msgs/CompressedVideo on NAME/h264
``voxel``  sensor_msgs/PointCloud2             the same type and name: one point of each cube
``every``  sensor_msgs/PointCloud2, LaserScan  the same type and name: every n-th point of each row
=========  ==================================  ===============================================================
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from pyros1.ground.errors import Error
from pyros1.ground.suggest import did_you_mean

IMAGE, CLOUD, SCAN = "sensor_msgs/Image", "sensor_msgs/PointCloud2", "sensor_msgs/LaserScan"


class ConversionError(Error, ValueError):
    """A rule selects an unknown conversion.

    Attributes:
        setting: the setting that is wrong.
    """

    def __init__(self, setting: str, text: str) -> None:
        super().__init__(text)
        self.setting = setting


class _Setting(NamedTuple):
    """The number that a conversion needs; `default` is None if the rule must specify it."""

    name: str
    default: float | None
    minimum: float
    maximum: float
    is_whole: bool
    meaning: str


class _Kind(NamedTuple):
    takes: tuple[str, ...]
    suffix: str
    setting: _Setting | None
    words: str


_IMAGE_TYPES, _CLOUD_TYPES = (IMAGE,), (CLOUD,)
_KINDS: Mapping[str, _Kind] = {
    "jpeg": _Kind(
        _IMAGE_TYPES, "/compressed", _Setting("quality", 80, 1, 100, True, "JPEG quality"), "as JPEG, quality {:g}"
    ),
    "png": _Kind(_IMAGE_TYPES, "/compressed", None, "as PNG"),
    "h264": _Kind(
        _IMAGE_TYPES,
        "/h264",
        _Setting("bitrate", 2e6, 5e4, 1e8, True, "bits per second"),
        "as H.264 video of about {mega:g} Mbit/s",
    ),
    "voxel": _Kind(
        _CLOUD_TYPES,
        "",
        _Setting("voxel", None, 1e-4, 1e4, False, "edge of a cube in metres"),
        "one point of each cube of {:g} m",
    ),
    "every": _Kind(
        (CLOUD, SCAN), "", _Setting("every", None, 2, 10_000, True, "2 for every second point"), "only 1 of {:g} points"
    ),
}
SETTINGS = ("convert", *(kind.setting.name for kind in _KINDS.values() if kind.setting))
"""A rule's settings for conversions."""


class MessageType(NamedTuple):
    """A message type: its name, md5 sum and full definition."""

    name: str
    md5sum: str
    definition: str


class Conversion(NamedTuple):
    """A conversion.

    Attributes:
        kind: a name in the first column of the table above.
        value: the number that it needs: quality, bits per second, metres, or n to keep every n-th point; 0 for none.
    """

    kind: str
    value: float

    @property
    def suffix(self) -> str:
        """The suffix for the topic's name if the type changes, so that the original can be sent, too."""
        return _KINDS[self.kind].suffix

    @property
    def takes(self) -> tuple[str, ...]:
        """The types that it can convert."""
        return _KINDS[self.kind].takes

    @property
    def keeps_latched(self) -> bool:
        """Whether a latched message is useful on its own: a single video frame is not."""
        return self.kind != "h264"

    @property
    def words(self) -> str:
        """The conversion in words, as part of a sentence."""
        return _KINDS[self.kind].words.format(self.value, mega=self.value / 1e6)


def read_conversion(fields: Mapping[str, Any]) -> Conversion | None:
    """Return the conversion that a rule's settings select; None if they select none.

    Raises:
        ConversionError: the settings are not valid.
    """
    name = fields.get("convert")
    if name is not None and (not isinstance(name, str) or name not in _KINDS):
        hint = did_you_mean(str(name), _KINDS)
        raise ConversionError("convert", f"there is no conversion {name!r:.40}{hint}; use {', '.join(_KINDS)}")
    setting = _KINDS[name].setting if name is not None else None
    for key in SETTINGS[1:]:
        if fields.get(key) is not None and (setting is None or key != setting.name):
            owner = next(each for each, kind in _KINDS.items() if kind.setting and kind.setting.name == key)
            raise ConversionError(key, f"{key} is only for convert: {owner}")
    if name is None:
        return None
    return Conversion(name, 0.0 if setting is None else _read_number(name, setting, fields.get(setting.name)))


def _read_number(kind: str, setting: _Setting, value: Any) -> float:
    if value is None:
        if setting.default is None:
            raise ConversionError("convert", f"convert: {kind} needs {setting.name} ({setting.meaning})")
        return setting.default
    types = int if setting.is_whole else (int, float)
    if isinstance(value, bool) or not isinstance(value, types) or not setting.minimum <= value <= setting.maximum:
        number = "a whole number" if setting.is_whole else "a number"
        raise ConversionError(
            setting.name,
            f"{setting.name} must be {number} from {setting.minimum:g} to {setting.maximum:g} ({setting.meaning}), not "
            f"{value!r:.40}",
        )
    return float(value)
