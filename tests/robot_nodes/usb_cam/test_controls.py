from __future__ import annotations

import struct
from typing import Any

import pytest

from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.usb_cam.controls import Control, read_controls


def names(**params: Any) -> dict[str, int]:
    return {control.name: control.value for control in read_controls(PrivateParameters(params, print))}


def test_without_parameters_the_camera_decides() -> None:
    assert names() == {"auto_white_balance": 1, "autofocus": 0}


@pytest.mark.parametrize(
    ("params", "found"),
    [
        ({"brightness": 10, "contrast": 50, "saturation": -1}, {"brightness": 10, "contrast": 50}),
        ({"autoexposure": False, "exposure": 150}, {"autoexposure": 1, "exposure": 150}),
        ({"autoexposure": True, "exposure": 150}, {}),
        ({"auto_white_balance": False}, {"auto_white_balance": 0, "white_balance": 4000}),
        ({"focus": 20}, {"focus": 20}),
        ({"focus": 20, "autofocus": True}, {"autofocus": 1}),
    ],
)
def test_parameters_become_controls(params: dict[str, Any], found: dict[str, int]) -> None:
    assert names(**params) == {"auto_white_balance": 1, "autofocus": 0, **found}


def test_automatics_are_switched_off_before_values_are_set() -> None:
    order = list(names(autoexposure=False, auto_white_balance=False, focus=1))
    assert order == ["auto_white_balance", "white_balance", "autoexposure", "exposure", "autofocus", "focus"]


def test_controls_have_the_numbers_of_the_kernels_header() -> None:
    found = {control.name: control.number for control in read_controls(PrivateParameters({"gain": 1}, print))}
    assert found == {"gain": 9963795, "auto_white_balance": 9963788, "autofocus": 10094860}
    assert struct.unpack("=Ii", Control("gain", 9963795, -2).encode()) == (9963795, -2)
