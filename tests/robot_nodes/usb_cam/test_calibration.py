from __future__ import annotations

from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from pyros1.msgs.sensor_msgs.msg import CameraInfo
from pyros1.robot_nodes.usb_cam.calibration import (
    CalibrationError,
    calibration_path,
    format_calibration,
    parse_calibration,
)

TEXT = """
image_width: 640
image_height: 480
camera_name: head_camera
camera_matrix:
  rows: 3
  cols: 3
  data: [500.5, 0, 320, 0, 501, 240, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.2, 0, 0, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [480, 0, 321, 0, 0, 481, 241, 0, 0, 0, 1, 0]
"""


def test_a_calibration_as_camera_calibration_writes_it() -> None:
    info, name = parse_calibration(TEXT)
    assert (info.width, info.height, name, info.distortion_model) == (640, 480, "head_camera", "plumb_bob")
    assert (info.K[0], info.K[4], info.P[2], list(info.D)[:2], info.R[8]) == (500.5, 501.0, 321.0, [0.1, -0.2], 1.0)


_numbers = st.floats(-1e6, 1e6)


@settings(max_examples=20)  # PyYAML is slow
@given(st.lists(_numbers, max_size=14), st.lists(_numbers, min_size=12, max_size=12), st.text(max_size=20))
def test_what_is_written_is_read_again(coefficients: list[float], values: list[float], name: str) -> None:
    info = CameraInfo(width=5, height=7, distortion_model="equidistant", D=coefficients)
    info.K, info.R, info.P = values[:9], values[3:], values
    again, found_name = parse_calibration(format_calibration(info, name))
    assert again == info and found_name == name


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"image_width": "wide"}, "image_width must be"),
        ({"image_height": -1}, "image_height must be"),
        ({"camera_matrix": {"data": [1, 2]}}, "camera_matrix must have data: a list of 9 numbers"),
        ({"camera_matrix": [1] * 9}, "camera_matrix must have data"),
        ({"projection_matrix": {"data": [True] * 12}}, "projection_matrix must have data: a list of 12 numbers"),
        (
            {"distortion_coefficients": {"data": [0.0] * 101}},
            "distortion_coefficients must have data: a list of numbers",
        ),
        ({"rectification_matrix": None}, "rectification_matrix must have data"),
    ],
)
def test_damaged_calibrations(change: dict[str, Any], problem: str) -> None:
    with pytest.raises(CalibrationError, match=problem):
        parse_calibration(yaml.safe_dump({**yaml.safe_load(TEXT), **change}))


@settings(max_examples=50)
@given(st.text(max_size=60))
def test_any_text_is_a_calibration_or_an_error_of_one_line(text: str) -> None:
    with pytest.raises(CalibrationError) as caught:
        parse_calibration(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("url", "path"),
    [
        ("", "/home/me/.ros/camera_info/left_eye.yaml"),
        ("file:///etc/camera.yaml", "/etc/camera.yaml"),
        ("file://${ROS_HOME}/${NAME}.yml", "/home/me/.ros/left_eye.yml"),
        ("package://my_robot/config/camera.yaml", "/opt/my_robot/config/camera.yaml"),
    ],
)
def test_urls_of_calibrations(url: str, path: str) -> None:
    assert calibration_path(url, "left eye", "/home/me/.ros", lambda name: f"/opt/{name}") == path


@pytest.mark.parametrize("url", ["camera.yaml", "http://host/camera.yaml", "file://camera.yaml", "package://my_robot"])
def test_other_urls(url: str) -> None:
    with pytest.raises(CalibrationError, match="camera_info_url must be"):
        calibration_path(url, "camera", "/home", lambda name: f"/opt/{name}")


@pytest.mark.parametrize(
    "text",
    [
        "!!int ''",
        "!!bool maybe",
        "!!timestamp soon",
        TEXT.replace("500.5", "1" + "0" * 400),
        TEXT
        + "a: &a [x, x, x, x, x, x, x, x, x]\n"
        + "".join(
            f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
        ),
    ],
)
def test_yaml_that_is_hard_to_read(text: str) -> None:
    with pytest.raises(CalibrationError):
        parse_calibration(text)


def test_numbers_with_exponents_as_other_programs_write_them() -> None:
    text = TEXT.replace("-0.2, 0", "-2e-1, 1e-05")
    assert text != TEXT
    info, _ = parse_calibration(text)
    assert list(info.D) == [0.1, -0.2, 1e-05, 0.0, 0.0]
