"""Publishes a camera's images and its calibration, for usb_cam and cv_camera."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from contextlib import closing
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from pyros1.diagnostics import ERROR, OK, Updater
from pyros1.finding.packages import PackageIndex
from pyros1.ground.atomic_file import write_atomically
from pyros1.ground.errors import Error
from pyros1.ground.timing import Duration, Time
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.msgs.sensor_msgs.srv import SetCameraInfo
from pyros1.node import Node
from pyros1.robot_nodes.image_proc.pixels import to_image
from pyros1.robot_nodes.image_proc.sizes import Scaling
from pyros1.robot_nodes.shared.user_files import read_regular_file
from pyros1.robot_nodes.usb_cam.calibration import (
    MAX_COEFFICIENTS,
    calibration_path,
    format_calibration,
    parse_calibration,
)
from pyros1.robot_nodes.usb_cam.video import Video, VideoEndedError, VideoError

RETRY_PERIOD = 2.0
"""Seconds between attempts to open the camera."""
_MAX_BYTES = 1 << 20


@dataclass(frozen=True)
class CameraOptions:
    """The options of a camera node.

    Attributes:
        device: the device or file, for the log and diagnostics.
        frame_id: the frame of the images.
        name: the camera's name.
        url: the URL of its calibration.
        encoding: the images' encoding.
        rate: images per second; 0 to publish all.
        is_live: whether the source determines when images arrive; images in files are read at `rate` instead.
        delay: seconds between taking an image and its arrival; subtracted from the stamps.
        rescale: whether to convert a calibration for another image size.
    """

    device: str
    frame_id: str
    name: str
    url: str = ""
    encoding: str = "rgb8"
    rate: float = 0.0
    is_live: bool = True
    delay: float = 0.0
    rescale: bool = False


class CameraDriver:
    """Publishes ``~image_raw`` and ``~camera_info`` until the node shuts down.

    Args:
        node: the node.
        options: the options.
        open_video: opens the camera, or raises VideoError; called again after errors.
    """

    def __init__(self, node: Node, options: CameraOptions, open_video: Callable[[], Video]) -> None:
        self._node, self._options, self._open_video = node, options, open_video
        self._problem = "starting"
        self._info = self._load_calibration()
        image_topic = node.resolve("~image_raw")
        self._images = node.advertise("~image_raw", Image, queue_size=1)
        self._infos = node.advertise(f"{image_topic.rpartition('/')[0]}/camera_info", CameraInfo, queue_size=1)
        node.advertise_service("~set_camera_info", SetCameraInfo, self._set_calibration)
        self.is_capturing = threading.Event()
        self.is_capturing.set()
        self._stopping = threading.Event()
        self._diagnostics = Updater(node, options.device)
        self._diagnostics.add("Camera", self._check)
        self._thread = threading.Thread(target=self._run, name=f"{node.name}:camera", daemon=True)
        self._thread.start()
        node.on_shutdown(self._stop)

    def _stop(self) -> None:
        self._stopping.set()
        self.is_capturing.set()
        self._thread.join(3.0)

    def _check(self, status: Any) -> None:
        status.summary(ERROR if self._problem else OK, self._problem or "images are coming")

    # Images -----------------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        said = ""
        while self.is_capturing.wait() and not self._stopping.is_set():
            try:
                with closing(self._open_video()) as video:
                    self._node.log.info("%s: started", self._options.device)
                    said = ""
                    self._capture(video)
                continue  # capturing was stopped
            except VideoError as error:
                self._problem = str(error)
                if isinstance(error, VideoEndedError) and not self._options.is_live:
                    self._node.log.info("%s", error)
                    return
            if self._problem != said:
                self._node.log.error("%s; trying again every %g s", self._problem, RETRY_PERIOD)
                said = self._problem
            self._stopping.wait(RETRY_PERIOD)

    def _capture(self, video: Video) -> None:
        """Publish images until the node ends or capturing is stopped."""
        period = 1 / self._options.rate if self._options.rate else 0.0
        due = time.monotonic()
        while not self._stopping.is_set():
            if not self.is_capturing.is_set():
                return  # the camera is closed, and opened again when capturing starts
            now = time.monotonic()
            if not self._options.is_live and now < due:
                self._stopping.wait(due - now)
            is_due = not self._options.is_live or now >= due - period / 4
            pixels = video.read(is_due and bool(self._images.num_connections))
            self._problem = ""
            if is_due and not self._stopping.is_set():
                due = max(due + period, time.monotonic() - period)
                self._publish(pixels)

    def _publish(self, pixels: Any) -> None:
        now, delay = self._node.now(), Duration.from_sec(self._options.delay)
        stamp = Time() if now - Time() < delay else now - delay  # simulated time begins at 0
        info = deepcopy(self._info)
        info.header.stamp, info.header.frame_id = stamp, self._options.frame_id
        if pixels is not None:
            if not info.K[0] and not info.width:
                self._info.height, self._info.width = info.height, info.width = pixels.shape[:2]
            elif self._must_rescale(info, pixels):
                info = Scaling(False, height=pixels.shape[0], width=pixels.shape[1]).apply_to_info(info)
            self._images.publish(to_image(info.header, pixels, self._options.encoding))
        self._infos.publish(info)

    def _must_rescale(self, info: Any, pixels: Any) -> bool:
        """Return whether a calibration is for another image size. If a service has set it, it may have no size."""
        size = info.height, info.width
        return self._options.rescale and all(size) and size != pixels.shape[:2]

    # The calibration --------------------------------------------------------------------------------------------------

    def _path(self) -> str:
        environ = self._node.environ
        home = environ.get("ROS_HOME") or os.path.join(os.path.expanduser("~"), ".ros")
        return calibration_path(self._options.url, self._options.name, home, PackageIndex(environ).find_folder)

    def _load_calibration(self) -> Any:
        log, name = self._node.log, self._options.name
        try:
            path = self._path()
            info, found_name = parse_calibration(read_regular_file(path, _MAX_BYTES).decode("utf-8", "replace"))
        except OSError as error:
            text = "the camera has no calibration: %s: %s; rosrun camera_calibration cameracalibrator.py makes one"
            log.warn(text, error.filename, error.strerror)
            return CameraInfo()
        except Error as error:
            log.error("the camera's calibration cannot be used: %s (%s)", error, self._options.url or "default")
            return CameraInfo()
        if found_name != name:
            log.warn("[%s] does not match name %s in file %s", name, found_name, path)
        log.info("camera calibration: %s", path)
        return info

    def _set_calibration(self, request: Any) -> Any:
        if len(request.camera_info.D) > MAX_COEFFICIENTS:
            return False, f"a calibration has at most {MAX_COEFFICIENTS} coefficients"
        self._info = deepcopy(request.camera_info)
        try:
            path = self._path()
            os.makedirs(os.path.dirname(path), exist_ok=True)
            write_atomically(path, format_calibration(request.camera_info, self._options.name))
        except OSError as error:
            return False, f"the calibration is used, but cannot be saved: {error.filename}: {error.strerror}"
        except Error as error:
            return False, f"the calibration is used, but cannot be saved: {error}"
        return True, ""
