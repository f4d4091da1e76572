"""A camera's calibration, which is loaded from a file, or set by the service ``set_camera_info`` and saved.

The file is YAML in the form of camera_calibration_parsers.
"""

from __future__ import annotations

import os
import re
import threading
from copy import deepcopy
from typing import Any

import rospkg
import rospy
import yaml

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.sensor_msgs.msg import CameraInfo
from pyros1.msgs.sensor_msgs.srv import SetCameraInfo, SetCameraInfoResponse

default_camera_info_url = "file://${ROS_HOME}/camera_info/${NAME}.yaml"

URL_empty, URL_file, URL_package, URL_invalid = 0, 1, 2, 3

_MATRICES = (("camera_matrix", "K", 3), ("rectification_matrix", "R", 3), ("projection_matrix", "P", 4))
_MAX_CHARACTERS = 1 << 20
"""Maximum number of characters to read from a file."""

__getattr__ = module_getattr(__name__)


class CameraInfoError(Exception):
    """A camera calibration cannot be used."""


class CameraInfoMissingError(CameraInfoError):
    """No calibration has been loaded."""


class CameraInfoManager:
    """A camera's calibration, which programs may change with the service ``set_camera_info``.

    Args:
        cname: the camera's name.
        url: URL of the calibration: ``file://...`` or ``package://NAME/...``; empty for a file in ROS_HOME. ``${NAME}``
        is replaced with the camera's name, and ``${ROS_HOME}`` with that folder.
        namespace: namespace of the service.
    """

    def __init__(self, cname: str = "camera", url: str = "", namespace: str = "") -> None:
        self.cname = cname
        self.url = url
        self.camera_info: Any = None
        self._lock = threading.RLock()
        service = "set_camera_info" if not namespace else namespace.rstrip("/") + "/set_camera_info"
        self.svc = rospy.Service(service, SetCameraInfo, self.setCameraInfo)

    def getCameraInfo(self) -> Any:
        """Return a copy of the calibration; raises CameraInfoMissingError before `loadCameraInfo`."""
        with self._lock:
            if self.camera_info is None:
                raise CameraInfoMissingError("Calibration missing, loadCameraInfo() needed.")
            return deepcopy(self.camera_info)

    def getCameraName(self) -> str:
        """Return the camera's name."""
        return self.cname

    def getURL(self) -> str:
        """Return the URL of the calibration."""
        return self.url

    def isCalibrated(self) -> bool:
        """Return whether there is a calibration; raises CameraInfoMissingError before `loadCameraInfo`."""
        return self.getCameraInfo().K[0] != 0.0  # type: ignore[no-any-return, unused-ignore]

    def loadCameraInfo(self) -> None:
        """Load the calibration, which is empty if there is no file."""
        with self._lock:
            self.camera_info = loadCalibration(self.url, self.cname)

    def setCameraInfo(self, req: Any) -> Any:
        """Set a calibration and save it. This is the service's handler."""
        with self._lock:
            self.camera_info = req.camera_info
        response = SetCameraInfoResponse()
        response.success = saveCalibration(req.camera_info, self.url, self.cname)
        if not response.success:
            response.status_message = "Error storing camera calibration."
        return response

    def setCameraName(self, cname: str) -> bool:
        """Change the camera's name; return whether it is legal. The calibration must be loaded again."""
        if not cname or re.search(r"\W", cname, re.ASCII):
            return False
        with self._lock:
            self.cname, self.camera_info = cname, None
        return True

    def setURL(self, url: str) -> bool:
        """Change the URL of the calibration; return whether it is legal. The calibration must be loaded again."""
        if parseURL(resolveURL(url, self.cname)) >= URL_invalid:
            return False
        with self._lock:
            self.url, self.camera_info = url, None
        return True


def genCameraName(from_string: str) -> str:
    """Convert a string to a legal camera name."""
    return re.sub(r"\W", "_", from_string, flags=re.ASCII)


def resolveURL(url: str, cname: str) -> str:
    """Return a URL with ``${NAME}`` and ``${ROS_HOME}`` replaced."""
    return url.replace("${NAME}", cname).replace("${ROS_HOME}", rospkg.get_ros_home())


def parseURL(url: str) -> int:
    """Return the kind of a URL: URL_empty, URL_file, URL_package or URL_invalid."""
    if not url:
        return URL_empty
    if url.lower().startswith("file:///"):
        return URL_file
    if url.lower().startswith("package://") and "/" in url[11:-1]:
        return URL_package
    return URL_invalid


def getPackageFileName(url: str) -> str:
    """Return the path of the file that a package:// URL names; empty if there is no such package."""
    package, _, name = url[len("package://") :].partition("/")
    try:
        return os.path.join(rospkg.RosPack().get_path(package), name)
    except rospkg.ResourceNotFound:
        rospy.logwarn("unknown package: %s (ignored)", package)
        return ""


def _file_path(url: str, cname: str) -> str:
    """Return the path of the file that a URL names; empty if the URL names no file."""
    resolved_url = resolveURL(url or default_camera_info_url, cname)
    url_type = parseURL(resolved_url)
    if url_type == URL_file:
        return resolved_url[len("file://") :]
    return getPackageFileName(resolved_url) if url_type == URL_package else ""


def loadCalibration(url: str, cname: str) -> Any:
    """Return the calibration at a URL; an empty one if there is none."""
    path = _file_path(url, cname)
    if not path:
        rospy.logerr("Invalid camera calibration URL: %s", url)
        return CameraInfo()
    return loadCalibrationFile(path, cname)


def loadCalibrationFile(filename: str, cname: str) -> Any:
    """Return the calibration in a file. If the file is missing or damaged, return an empty one; damage is logged."""
    message = CameraInfo()
    try:
        with open(filename, encoding="utf-8") as file:
            values = yaml.safe_load(file.read(_MAX_CHARACTERS))
        if values.get("camera_name") != cname:
            rospy.logwarn("[%s] does not match name %s in file %s", cname, values.get("camera_name"), filename)
        message.width, message.height = values["image_width"], values["image_height"]
        message.distortion_model = values["distortion_model"]
        message.D = values["distortion_coefficients"]["data"]
        for key, field, _ in _MATRICES:
            setattr(message, field, values[key]["data"])
    except OSError:
        return CameraInfo()  # an empty calibration until one is set
    except (yaml.YAMLError, KeyError, TypeError, AttributeError, ValueError) as error:
        rospy.logerr("camera calibration in %s cannot be used: %s", filename, error)
        return CameraInfo()
    return message


def saveCalibration(new_info: Any, url: str, cname: str) -> bool:
    """Save a calibration at a URL; return whether it was saved."""
    path = _file_path(url, cname)
    if not path:
        rospy.logerr("Invalid camera calibration URL: %s", url)
        return False
    return saveCalibrationFile(new_info, path, cname)


def saveCalibrationFile(ci: Any, filename: str, cname: str) -> bool:
    """Save a calibration in a file; return whether it was saved."""
    values = {
        "image_width": ci.width,
        "image_height": ci.height,
        "camera_name": cname,
        "distortion_model": ci.distortion_model,
        "distortion_coefficients": {"data": list(ci.D), "rows": 1, "cols": len(ci.D)},
    }
    for key, field, columns in _MATRICES:
        values[key] = {"data": list(getattr(ci, field)), "rows": 3, "cols": columns}
    try:
        os.makedirs(os.path.dirname(filename), exist_ok=True)
        with open(filename, "w", encoding="utf-8") as file:
            yaml.safe_dump(values, file)
    except OSError as error:
        rospy.logerr("file [%s] cannot be written: %s", filename, error)
        return False
    return True
