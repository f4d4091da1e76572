"""Controls of V4L2 cameras, such as brightness and exposure, from usb_cam's parameters (no I/O)."""

from __future__ import annotations

import struct
from typing import NamedTuple

from pyros1.robot_nodes.shared.parameters import PrivateParameters

SET_CONTROL = 0xC008561C
"""The ioctl VIDIOC_S_CTRL."""
_USER, _CAMERA = 0x00980900, 0x009A0900
_NUMBERS = {"brightness": _USER, "contrast": _USER + 1, "saturation": _USER + 2, "gain": _USER + 0x13}
_NUMBERS["sharpness"] = _USER + 0x1B
_MANUAL_EXPOSURE = 1


class Control(NamedTuple):
    """A control, with its V4L2 id and its new value."""

    name: str
    number: int
    value: int

    def encode(self) -> bytes:
        """Return it as ``struct v4l2_control``."""
        return struct.pack("=Ii", self.number, self.value)


def read_controls(params: PrivateParameters) -> list[Control]:
    """Return the controls to set, in the required order; a parameter of -1 leaves a control unchanged."""
    found = []
    for name, number in _NUMBERS.items():
        value = params.integer(name, -1, -(2**31), 2**31 - 1)
        if value >= 0:
            found.append(Control(name, number, value))
    is_automatic = params.flag("auto_white_balance", True)
    found.append(Control("auto_white_balance", _USER + 0x0C, int(is_automatic)))
    if not is_automatic:
        found.append(Control("white_balance", _USER + 0x1A, params.integer("white_balance", 4000, 0, 2**31 - 1)))
    if not params.flag("autoexposure", True):
        found.append(Control("autoexposure", _CAMERA + 1, _MANUAL_EXPOSURE))
        found.append(Control("exposure", _CAMERA + 2, params.integer("exposure", 100, 0, 2**31 - 1)))
    focuses = params.flag("autofocus", False)
    found.append(Control("autofocus", _CAMERA + 0x0C, int(focuses)))
    focus = params.integer("focus", -1, -(2**31), 2**31 - 1)
    if not focuses and focus >= 0:
        found.append(Control("focus", _CAMERA + 0x0A, focus))
    return found
