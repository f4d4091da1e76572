"""Camera calibrations as YAML, in camera_calibration_parsers' format, and the URLs of their files (no I/O)."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

import yaml

from pyros1.ground.errors import Error
from pyros1.msgs.sensor_msgs.msg import CameraInfo
from pyros1.robot_nodes.shared.user_files import yaml_number
from pyros1.values.reading import YamlError, load_yaml

DEFAULT_URL = "file://${ROS_HOME}/camera_info/${NAME}.yaml"
_MATRICES = (("camera_matrix", "K", 3, 3), ("rectification_matrix", "R", 3, 3), ("projection_matrix", "P", 3, 4))
MAX_COEFFICIENTS = 100


class CalibrationError(Error):
    """A calibration cannot be used."""


def parse_calibration(text: str) -> tuple[Any, str]:
    """Return the sensor_msgs/CameraInfo of a calibration, and the camera's name, or an empty string if it has none.

    Raises:
        CalibrationError: the text is not a calibration.
    """
    try:
        values = load_yaml(text)
    except YamlError as error:
        raise CalibrationError(f"it is not valid YAML: {' '.join(str(error).split())[:200]}") from None
    if not isinstance(values, Mapping):
        raise CalibrationError("it has no image_width, image_height, camera_matrix and so on")
    info = CameraInfo(distortion_model=str(values.get("distortion_model", "plumb_bob")))
    info.width, info.height = (_size(values, name) for name in ("image_width", "image_height"))
    info.D = _numbers(values, "distortion_coefficients", None)
    for key, field, rows, columns in _MATRICES:
        setattr(info, field, _numbers(values, key, rows * columns))
    return info, str(values.get("camera_name", ""))


def _size(values: Mapping[Any, Any], name: str) -> int:
    value = values.get(name)
    if not isinstance(value, int) or not 0 <= value < 2**32:
        raise CalibrationError(f"{name} must be a number of pixels")
    return value


def _numbers(values: Mapping[Any, Any], name: str, count: int | None) -> list[float]:
    part = values.get(name)
    data = part.get("data") if isinstance(part, Mapping) else None
    usable = isinstance(data, list) and len(data) <= MAX_COEFFICIENTS and (count is None or len(data) == count)
    numbers = [value if type(value) is float else yaml_number(value) for value in data] if usable and data else []
    found = [number for number in numbers if number is not None]
    if not usable or len(found) < len(numbers):
        raise CalibrationError(f"{name} must have data: a list of {'' if count is None else f'{count} '}numbers")
    return found


def format_calibration(info: Any, camera_name: str) -> str:
    """Return a calibration as text."""
    values = {
        "image_width": info.width,
        "image_height": info.height,
        "camera_name": camera_name,
        "camera_matrix": _matrix(info.K, 3),
        "distortion_model": info.distortion_model,
        "distortion_coefficients": {"rows": 1, "cols": len(info.D), "data": [float(value) for value in info.D]},
        "rectification_matrix": _matrix(info.R, 3),
        "projection_matrix": _matrix(info.P, 4),
    }
    text: str = yaml.safe_dump(values, sort_keys=False, default_flow_style=None)
    return text


def _matrix(values: Any, columns: int) -> dict[str, Any]:
    return {"rows": 3, "cols": columns, "data": [float(value) for value in values]}


def calibration_path(url: str, camera_name: str, ros_home: str, find_package: Callable[[str], str]) -> str:
    """Return the path of the file that a URL refers to.

    Args:
        url: ``file:///...`` or ``package://PACKAGE/...``; empty for a file in ROS_HOME. ``${NAME}`` stands for the
            camera's name, and ``${ROS_HOME}`` for `ros_home`.
        camera_name: the camera's name.
        ros_home: the folder ROS_HOME.
        find_package: returns the folder of a package.

    Raises:
        CalibrationError: the URL has another form.
        PackageNotFoundError: raised by `find_package`.
    """
    name = re.sub(r"\W", "_", camera_name, flags=re.ASCII)
    resolved = (url or DEFAULT_URL).replace("${NAME}", name).replace("${ROS_HOME}", ros_home)
    if match := re.match(r"file://(/.+)", resolved):
        return match[1]
    if match := re.match(r"package://([^/]+)/(.+)", resolved):
        return f"{find_package(match[1])}/{match[2]}"
    raise CalibrationError(f"camera_info_url must be file:///PATH or package://PACKAGE/PATH, not {url!r:.100}")
