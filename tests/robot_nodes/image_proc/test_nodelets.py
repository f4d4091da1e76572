"""image_proc's nodes: what they publish, when they subscribe, and what they say.

Feature: images without Bayer pattern and distortion -- `ROS_NAMESPACE=camera pyros1 run image_proc image_proc`; also
    debayer, rectify, resize and crop_decimate
"""

from __future__ import annotations

import time
from collections.abc import Callable
from queue import Queue
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.reconfigure import Client
from pyros1.robot_nodes.image_proc.nodelets import Debayer, Rectify
from pyros1.robot_nodes.image_proc.programs import start_image_proc
from pyros1.robot_nodes.image_proc.remap import LINEAR, NEAREST, Remap
from pyros1.robot_nodes.image_proc.size_nodelets import CropDecimate, Resize

from ..logs import wait_for_line

PATIENCE = 20.0


class Camera:
    """A node that publishes images, and collects what is made of them."""

    def __init__(self, make_node: Callable[..., Any], namespace: str = "/camera") -> None:
        self.node = make_node("source", namespace=namespace)
        self.images = self.node.advertise("image_raw", Image)
        self.infos = self.node.advertise("camera_info", CameraInfo)

    def listen(self, topic: str, cls: Any = Image) -> Queue[Any]:
        found: Queue[Any] = Queue()
        self.node.subscribe(topic, cls, found.put)
        return found

    def publish(self, encoding: str, data: Any, **info: Any) -> None:
        image = Image(height=data.shape[0], width=data.shape[1], encoding=encoding, step=data.strides[0])
        image.data = data.tobytes()
        image.header.stamp = self.node.now()
        self.images.publish(image)
        self.infos.publish(camera_info(data, header=image.header, **info))

    def publish_until(self, found: Queue[Any], *args: Any, **info: Any) -> Any:
        """Publish until something comes: links between the nodes take some time."""
        publish_until(lambda: not found.empty(), lambda: self.publish(*args, **info))
        return found.get()


def publish_until(condition: Callable[[], object], publish: Callable[[], object]) -> None:
    """Publish until a condition is true, but not so often that a slow machine has always newer messages to handle."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it never came true"
        publish()
        pause = time.monotonic() + 0.1
        while not condition() and time.monotonic() < pause:
            time.sleep(0.002)


def camera_info(data: Any, **fields: Any) -> Any:
    k = [20.0, 0.0, 8.0, 0.0, 20.0, 6.0, 0.0, 0.0, 1.0]
    p = [20.0, 0.0, 8.0, 0.0, 0.0, 20.0, 6.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    usual = {"height": data.shape[0], "width": data.shape[1], "K": k, "P": p, "distortion_model": "plumb_bob"}
    return CameraInfo(**{**usual, "D": [0.1, 0.0, 0.0, 0.0, 0.0], **fields})


@pytest.fixture
def camera(make_node: Callable[..., Any]) -> Camera:
    return Camera(make_node)


def array(image: Any, channels: int = 3) -> Any:
    return np.frombuffer(image.data, "u1").reshape(image.height, image.width, channels)


RED = np.tile(np.array([[200, 100], [100, 40]], "u1"), (6, 8))


def test_one_program_makes_all_four_images(camera: Camera, make_node: Callable[..., Any]) -> None:
    node = make_node("image_proc", namespace="/camera")
    kept = start_image_proc(node)
    published = {topic for topic, _ in camera.node.master.get_published_topics()}
    names = ("image_mono", "image_color", "image_rect", "image_rect_color")
    assert {f"/camera/{name}" for name in names} <= published
    assert camera.images.num_connections == 0  # nobody wants anything yet
    rect = camera.listen("image_rect_color")
    found = camera.publish_until(rect, "bayer_rggb8", RED)
    assert (found.encoding, found.height, found.width) == ("bgr8", 12, 16)
    assert array(found)[5, 7].tolist() == [40, 100, 200]
    mono = camera.listen("image_mono")
    assert camera.publish_until(mono, "bayer_rggb8", RED).encoding == "mono8"
    color = camera.listen("image_color")
    assert (array(camera.publish_until(color, "bayer_rggb8", RED)) == [40, 100, 200]).all()
    config = Client(camera.node, "/camera/image_proc_rectify_color").update({"interpolation": 0}, timeout=PATIENCE)
    assert config.interpolation == 0 and len(kept) == 4


def test_a_node_subscribes_only_while_it_is_needed(
    camera: Camera, make_node: Callable[..., Any], until: Callable[..., None]
) -> None:
    node = make_node("debayer", namespace="/camera")
    Debayer(node)
    listener = camera.node.subscribe("image_color", Image, lambda image: None)
    until(lambda: camera.images.num_connections)
    listener.unregister()
    until(lambda: not camera.images.num_connections)
    camera.node.subscribe("image_mono", Image, lambda image: None)
    until(lambda: camera.images.num_connections)


def test_problems_are_said_once(
    camera: Camera, make_node: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    node = make_node("rectify", namespace="/camera")
    Debayer(node)
    Rectify(node, "/camera/rect", queue_size=2)
    color, rect = camera.listen("image_color"), camera.listen("image_rect")
    grey = np.zeros((12, 16), "u1")
    camera.publish_until(color, "mono8", grey)
    camera.publish_until(rect, "mono8", grey, D=[])
    said: list[str] = []

    def is_said(problem: str) -> bool:
        said.append(capfd.readouterr().err)
        return problem in "".join(said)

    def publish_uncalibrated() -> None:
        camera.publish("mono8", grey, K=[0.0] * 9, D=[0.5])

    def publish_jpeg() -> None:
        camera.publish("jpeg", grey)

    # One at a time: of two that arrive together, only the newer one is handled.
    publish_until(lambda: is_said("/camera/image_rect is wanted, but the camera is uncalibrated"), publish_uncalibrated)
    publish_until(lambda: is_said("'jpeg' are not supported"), publish_jpeg)
    assert is_said("is wanted in color, but the images on /camera/image_raw have none")
    for _ in range(3):
        publish_uncalibrated()
        publish_jpeg()
        camera.publish_until(color, "mono8", grey)
        camera.publish_until(rect, "mono8", grey, D=[])
    said.append(capfd.readouterr().err)
    assert len("".join(said).splitlines()) == 3


def test_an_image_that_does_not_fit_its_camera_info(
    camera: Camera, make_node: Callable[..., Any], until: Callable[..., None], capfd: pytest.CaptureFixture[str]
) -> None:
    node = make_node("rectify", namespace="/camera", argv=["image_mono:=image_raw", "_interpolation:=4"])
    Rectify(node)
    camera.listen("image_rect")
    until(lambda: camera.images.num_connections and camera.infos.num_connections)
    said = []

    def complained() -> bool:
        said.append(capfd.readouterr().err)
        return "8 x 6 pixels, but with camera_info it should have 16 x 12" in "".join(said)

    publish_until(complained, lambda: camera.publish("mono8", np.zeros((6, 8), "u1"), width=16, height=12))
    assert "Linear is used instead of 4" in "".join(said)


def test_resize_and_crop_decimate(camera: Camera, make_node: Callable[..., Any]) -> None:
    half = make_node("half", namespace="/camera", argv=["image:=image_raw", "_scale_width:=0.5", "_scale_height:=0.5"])
    Resize(half)
    images, infos = camera.listen("half/image"), camera.listen("half/camera_info", CameraInfo)
    rgb = np.full((12, 16, 3), 90, "u1")
    found = camera.publish_until(images, "rgb8", rgb)
    assert (found.height, found.width, found.encoding) == (6, 8, "rgb8")
    assert camera.publish_until(infos, "rgb8", rgb).K[0] == 10.0

    crop = make_node("crop", argv=["camera_out:=/part", "_width:=4", "_decimation_x:=2", "_interpolation:=3"])
    CropDecimate(crop, 5)
    images, infos = camera.listen("/part/image_raw"), camera.listen("/part/camera_info", CameraInfo)
    found = camera.publish_until(images, "rgb8", rgb)
    assert (found.height, found.width) == (12, 2)
    assert camera.publish_until(infos, "rgb8", rgb).binning_x == 2


def test_the_interpolation_can_be_changed_at_any_time(
    camera: Camera, make_node: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    Rectify(make_node("rectify", namespace="/camera", argv=["image_mono:=image_raw"]))
    rect = camera.listen("image_rect")
    grey = np.tile(np.array([0, 200], "u1"), (12, 8))
    used: list[int] = []

    class SlowRemap(Remap):
        """A map that is made while the interpolation is changed."""

        def __init__(self, x: Any, y: Any, size: tuple[int, int], interpolation: int = LINEAR) -> None:
            used.append(interpolation)
            if len(used) == 1:
                Client(camera.node, "/camera/rectify").update({"interpolation": NEAREST}, timeout=PATIENCE)
            super().__init__(x, y, size, interpolation)

    monkeypatch.setattr("pyros1.robot_nodes.image_proc.nodelets.Remap", SlowRemap)
    while len(used) < 2:
        camera.publish_until(rect, "mono8", grey)
    assert used[:2] == [LINEAR, NEAREST]


def test_a_camera_info_that_cannot_be_enlarged(
    camera: Camera, make_node: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    node = make_node("double", argv=["image:=/camera/image_raw", "camera_info:=/camera/camera_info"])
    node.params["~scale_width"] = 2.0
    Resize(node)
    found = camera.listen("/double/camera_info", CameraInfo)
    first = camera.publish_until(found, "mono8", RED)
    assert first.width == 2 * RED.shape[1]
    info = camera_info(RED)
    info.roi.x_offset = 2**32 - 1
    camera.infos.publish(info)
    wait_for_line(capfd, "/camera/camera_info: /double/camera_info: field roi.x_offset")
