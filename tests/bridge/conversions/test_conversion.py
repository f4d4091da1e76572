"""The settings by which rules ask for conversions."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.bridge.conversions.conversion import SETTINGS, Conversion, ConversionError, read_conversion


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({}, None),
        ({"convert": None}, None),
        ({"convert": "jpeg"}, ("jpeg", 80.0)),
        ({"convert": "jpeg", "quality": 1}, ("jpeg", 1.0)),
        ({"convert": "png"}, ("png", 0.0)),
        ({"convert": "h264", "bitrate": 500_000}, ("h264", 5e5)),
        ({"convert": "voxel", "voxel": 1}, ("voxel", 1.0)),
        ({"convert": "every", "every": 10}, ("every", 10.0)),
    ],
)
def test_settings(fields: dict[str, Any], expected: Any) -> None:
    assert read_conversion(fields) == expected


@pytest.mark.parametrize(
    ("fields", "setting", "complaint"),
    [
        ({"convert": "h265"}, "convert", "there is no conversion 'h265' (did you mean 'h264'?"),
        ({"convert": ["jpeg"]}, "convert", "there is no conversion"),
        ({"convert": "jpeg", "quality": 101}, "quality", "quality must be a whole number from 1 to 100"),
        ({"convert": "jpeg", "quality": 50.5}, "quality", "whole number"),
        ({"convert": "jpeg", "quality": True}, "quality", "whole number"),
        ({"convert": "voxel", "voxel": float("nan")}, "voxel", "voxel must be a number from 0.0001"),
        ({"convert": "voxel", "voxel": "0.1"}, "voxel", "not '0.1'"),
        ({"convert": "every"}, "convert", "convert: every needs every (2 for every second point)"),
        ({"convert": "every", "every": 1}, "every", "from 2 to"),
        ({"convert": "every", "every": 2, "voxel": 1}, "voxel", "voxel is only for convert: voxel"),
        ({"every": 2}, "every", "every is only for convert: every"),
    ],
)
def test_settings_that_are_wrong(fields: dict[str, Any], setting: str, complaint: str) -> None:
    with pytest.raises(ConversionError) as caught:
        read_conversion(fields)
    assert caught.value.setting == setting and complaint in str(caught.value)


def test_what_is_said_of_them() -> None:
    assert {*SETTINGS} == {"convert", "quality", "bitrate", "voxel", "every"}
    assert Conversion("h264", 1.5e6).words == "as H.264 video of about 1.5 Mbit/s"
    assert [Conversion(kind, 1.0).suffix for kind in ("jpeg", "png", "h264", "voxel", "every")] == [
        "/compressed",
        "/compressed",
        "/h264",
        "",
        "",
    ]
    assert [Conversion(kind, 1.0).keeps_latched for kind in ("jpeg", "h264", "voxel")] == [True, False, True]
