"""usb_cam_node and cv_camera_node (https://wiki.ros.org/usb_cam, https://wiki.ros.org/cv_camera)."""

from __future__ import annotations

import os
from typing import Any

from pyros1.ground.errors import SettingError
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.node import Node
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.robot_nodes.usb_cam.controls import SET_CONTROL, Control, read_controls
from pyros1.robot_nodes.usb_cam.driver import CameraDriver, CameraOptions
from pyros1.robot_nodes.usb_cam.video import AvVideo

INPUT_FORMATS = {
    "yuyv": "yuyv422",
    "uyvy": "uyvy422",
    "mjpeg": "mjpeg",
    "rgb24": "rgb24",
    "grey": "gray",
    "h264": "h264",
}
"""Value of usb_cam's ``~pixel_format`` -> libav's name for it."""
_MAX_SIZE = 65535


def start_usb_cam(node: Node) -> CameraDriver:
    """Start a camera with usb_cam's parameters.

    Raises:
        SettingError: the pixel format is unknown.
    """
    params = PrivateParameters.of(node)
    device = params.text("video_device", "/dev/video0")
    name = params.text("pixel_format", "mjpeg")
    if name not in INPUT_FORMATS:
        raise SettingError(
            f"the pixel format {name!r:.40} is unknown: ~pixel_format is one of {', '.join(INPUT_FORMATS)}"
        )
    size = params.integer("image_width", 640, 1, _MAX_SIZE), params.integer("image_height", 480, 1, _MAX_SIZE)
    options = {"video_size": f"{size[0]}x{size[1]}", "framerate": str(params.integer("framerate", 30, 1, 1000))}
    pixels = "gray" if name == "grey" else "rgb24"
    controls = read_controls(params)

    def open_video() -> AvVideo:
        video = AvVideo(device, "v4l2", {**options, "input_format": INPUT_FORMATS[name]}, pixels)
        _set_controls(node, device, controls)
        return video

    driver = CameraDriver(
        node,
        CameraOptions(
            device=device,
            frame_id=params.text("camera_frame_id", "head_camera"),
            name=params.text("camera_name", "head_camera"),
            url=params.text("camera_info_url", ""),
            encoding="mono8" if name == "grey" else "rgb8",
        ),
        open_video,
    )
    node.advertise_service("~start_capture", Empty, lambda request: _do(driver.is_capturing.set))
    node.advertise_service("~stop_capture", Empty, lambda request: _do(driver.is_capturing.clear))
    return driver


def _do(action: Any) -> tuple[()]:
    action()
    return ()


def _set_controls(node: Node, device: str, controls: list[Control]) -> None:
    """Set a device's controls. Most cameras lack some, so warnings are logged only for those that a user has chosen."""
    import fcntl  # noqa: PLC0415 - Windows has neither this nor such devices

    try:
        file = os.open(device, os.O_RDWR | os.O_NONBLOCK)
    except OSError as error:
        node.log.warn("%s: its controls cannot be set: %s", device, error.strerror)
        return
    try:
        for control in controls:
            try:
                fcntl.ioctl(file, SET_CONTROL, control.encode())
            except OSError as error:
                level = node.log.debug if control.name.startswith("auto") else node.log.warn
                level("%s: %s cannot be set to %d: %s", device, control.name, control.value, error.strerror)
    finally:
        os.close(file)


def start_cv_camera(node: Node) -> CameraDriver:
    """Start a camera or a video file with cv_camera's parameters."""
    params = PrivateParameters.of(node)
    file = params.text("file", "")
    device = params.text("device_path", "") or f"/dev/video{params.integer('device_id', 0, 0, 10000)}"
    frame_id = params.text("frame_id", "camera")
    rate = params.number("rate", 30.0, 0.01, 1000.0)
    options = {}
    sizes = [_cv_number(params, name) for name in ("width", "height")]
    if all(sizes) and not file:
        options["video_size"] = f"{sizes[0]}x{sizes[1]}"
    fps = params.number("cv_cap_prop_fps", 0.0, 0.0, 1000.0)
    if fps and not file:
        options["framerate"] = f"{fps:g}"
    return CameraDriver(
        node,
        CameraOptions(
            device=file or device,
            frame_id=frame_id,
            name=params.text("camera_name", frame_id),
            url=params.text("camera_info_url", ""),
            encoding="bgr8",
            rate=rate,
            is_live=not file,
            delay=params.number("capture_delay", 0.0, -1000.0, 1000.0),
            rescale=params.flag("rescale_camera_info", False),
        ),
        lambda: AvVideo(file or device, None if file else "v4l2", options, "bgr24"),
    )


def _cv_number(params: PrivateParameters, name: str) -> int:
    other = params.integer(f"cv_cap_prop_frame_{name}", 0, 0, _MAX_SIZE)
    return params.integer(f"image_{name}", other, 0, _MAX_SIZE)


def main_usb_cam(argv: list[str]) -> int:
    """Run usb_cam_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "usb_cam", start_usb_cam)


def main_cv_camera(argv: list[str]) -> int:
    """Run cv_camera_node; see `main_usb_cam`."""
    return run_node(argv, "cv_camera", start_cv_camera)
