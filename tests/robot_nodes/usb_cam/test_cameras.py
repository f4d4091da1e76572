"""The nodes of cameras, with a simulated camera, and with videos that libav makes.

Feature: cameras -- `pyros1 run usb_cam usb_cam_node`, or `cv_camera cv_camera_node`, which also plays video files;
    needs the extra `video`
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from queue import Queue
from typing import Any

import numpy as np
import pytest

from pyros1.ground.errors import SettingError
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.msgs.sensor_msgs.srv import SetCameraInfo
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.robot_nodes.usb_cam.driver import CameraDriver, CameraOptions
from pyros1.robot_nodes.usb_cam.programs import start_cv_camera, start_usb_cam
from pyros1.robot_nodes.usb_cam.video import AvVideo, VideoEndedError, VideoError

PATIENCE = 20.0
OPTIONS = CameraOptions("/dev/video7", "lens", "head_camera")


class FakeVideo:
    """A camera with a picture of 2 x 3 pixels, whose images come when the test says so."""

    def __init__(self) -> None:
        self.images: Queue[Any] = Queue()
        self.wanted: list[bool] = []
        self.closed = threading.Event()

    def read(self, is_wanted: bool) -> Any:
        self.wanted.append(is_wanted)
        image = self.images.get()
        if isinstance(image, Exception):
            raise image
        return np.full((2, 3, 3), image, "u1") if is_wanted else None

    def close(self) -> None:
        self.closed.set()


def listen(node: Any, topic: str, cls: Any) -> Queue[Any]:
    found: Queue[Any] = Queue()
    node.subscribe(topic, cls, found.put)
    return found


def feed_until(video: FakeVideo, found: Queue[Any], until: Callable[..., None]) -> Any:
    def came() -> bool:
        video.images.put(9)
        return not found.empty()

    until(came)
    return found.get()


def finish(node: Any, video: FakeVideo) -> None:
    """End a node: its camera still gives an image, as real ones do."""
    video.images.put(0)
    video.images.put(0)
    node.shutdown()


def test_images_and_calibration_are_published_together(
    make_node: Callable[..., Any], until: Callable[..., None]
) -> None:
    video, node, peer = FakeVideo(), make_node("usb_cam"), make_node("peer")
    infos = listen(peer, "/usb_cam/camera_info", CameraInfo)
    CameraDriver(node, OPTIONS, lambda: video)
    info = feed_until(video, infos, until)
    assert (info.header.frame_id, info.K[0]) == ("lens", 0.0) and not any(video.wanted)  # nothing was decoded
    images = listen(peer, "/usb_cam/image_raw", Image)
    image = feed_until(video, images, until)
    assert (image.encoding, image.height, image.width, bytes(image.data)) == ("rgb8", 2, 3, b"\x09" * 18)
    stamps: dict[str, set[Any]] = {"image": {image.header.stamp}, "info": set()}

    def have_the_same_stamp() -> bool:
        """Whether an image and a calibration have; single ones may be replaced by newer ones."""
        stamps["image"].add(feed_until(video, images, until).header.stamp)
        stamps["info"].update(infos.get().header.stamp for _ in range(infos.qsize()))
        return bool(stamps["image"] & stamps["info"])

    until(have_the_same_stamp)
    finish(node, video)
    assert video.closed.is_set()


def test_a_camera_that_is_absent_or_unplugged(
    make_node: Callable[..., Any], until: Callable[..., None], capfd: pytest.CaptureFixture[str], monkeypatch: Any
) -> None:
    monkeypatch.setattr("pyros1.robot_nodes.usb_cam.driver.RETRY_PERIOD", 0.01)
    video, node, peer = FakeVideo(), make_node("usb_cam", argv=["_diagnostic_period:=0.02"]), make_node("peer")
    statuses = listen(peer, "/diagnostics", DiagnosticArray)
    plugged, attempts = threading.Event(), []

    def open_video() -> FakeVideo:
        attempts.append(1)
        if not plugged.is_set():
            raise VideoError("there is no /dev/video7")
        return video

    CameraDriver(node, OPTIONS, open_video)
    until(lambda: len(attempts) > 5)

    def await_status(level: int, text: str) -> None:
        until(lambda: ((found := statuses.get(timeout=PATIENCE).status[0]).level, found.message) == (level, text))

    await_status(2, "there is no /dev/video7")
    plugged.set()
    video.images.put(1)
    await_status(0, "images are coming")
    plugged.clear()
    video.images.put(VideoError("/dev/video7: No such device"))
    assert video.closed.wait(PATIENCE)
    await_status(2, "there is no /dev/video7")
    plugged.set()
    video.images.put(1)
    await_status(0, "images are coming")
    finish(node, video)
    lines = [line for line in capfd.readouterr().err.splitlines() if "[ERROR]" in line]
    assert len(lines) == 3
    assert "there is no /dev/video7; trying again every" in lines[0] and "No such device; trying" in lines[1]


def test_a_calibration_is_set_saved_and_loaded(
    make_node: Callable[..., Any], until: Callable[..., None], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    video, node, peer = FakeVideo(), make_node("usb_cam"), make_node("peer")
    CameraDriver(node, OPTIONS, lambda: video)
    info = CameraInfo(width=6, height=4, distortion_model="plumb_bob", D=[0.5], K=[7.0, *[0.0] * 7, 1.0])
    service = peer.service("/usb_cam/set_camera_info", SetCameraInfo)
    response = service(CameraInfo(D=[0.5] * 101))
    assert (response.success, response.status_message) == (False, "a calibration has at most 100 coefficients")
    response = service(info)
    assert response.success
    assert list(tmp_path.rglob("camera_info/head_camera.yaml"))
    finish(node, video)

    video, node = FakeVideo(), make_node("usb_cam")
    infos, images = listen(peer, "/usb_cam/camera_info", CameraInfo), listen(peer, "/usb_cam/image_raw", Image)
    options = CameraOptions("/dev/video7", "lens", "head_camera", rescale=True)
    CameraDriver(node, options, lambda: video)
    feed_until(video, images, until)
    until(lambda: infos.get(timeout=PATIENCE).K[0] == 3.5)  # the images have half the size
    finish(node, video)
    said = capfd.readouterr()
    assert "the camera has no calibration" in said.err and "camera calibration: " in said.out


def test_a_calibration_without_size_and_a_delay_from_before_time_began(
    make_node: Callable[..., Any], until: Callable[..., None]
) -> None:
    video, node, peer = FakeVideo(), make_node("usb_cam"), make_node("peer")
    images = listen(peer, "/usb_cam/image_raw", Image)
    CameraDriver(node, CameraOptions("/dev/video7", "lens", "head_camera", rescale=True, delay=1e10), lambda: video)
    service = peer.service("/usb_cam/set_camera_info", SetCameraInfo)
    service(CameraInfo(K=[7.0, *[0.0] * 7, 1.0]))
    assert feed_until(video, images, until).header.stamp.to_sec() < 1
    finish(node, video)


def test_every_image_of_a_file_is_published(make_node: Callable[..., Any], until: Callable[..., None]) -> None:
    video, node, peer = FakeVideo(), make_node("film"), make_node("peer")
    for shade in range(6):
        video.images.put(shade)
    video.images.put(VideoEndedError("film.avi has ended"))
    images = listen(peer, "/film/image_raw", Image)
    opened = threading.Event()

    def open_video() -> FakeVideo:
        opened.wait(PATIENCE)
        return video

    CameraDriver(node, CameraOptions("film.avi", "lens", "film", rate=100.0, is_live=False), open_video)
    until(lambda: peer_is_connected(node, "/film/image_raw"))
    opened.set()
    came = [images.get(timeout=PATIENCE).data[0]]
    while came[-1] != 5:
        came.append(images.get(timeout=PATIENCE).data[0])
    assert came == sorted(came)  # a link that is too slow drops some
    assert video.closed.wait(PATIENCE) and video.wanted == [True] * 7


def peer_is_connected(node: Any, topic: str) -> bool:
    """Return whether a node sends a topic to somebody."""
    return bool(node.advertise(topic, Image).num_connections)


def test_capturing_can_be_stopped(make_node: Callable[..., Any], until: Callable[..., None]) -> None:
    videos: list[FakeVideo] = []
    node, peer = make_node("usb_cam", argv=["_video_device:=/dev/null"]), make_node("peer")
    driver = CameraDriver(node, OPTIONS, lambda: videos.append(FakeVideo()) or videos[-1])  # type: ignore[func-returns-value]
    until(lambda: videos)
    driver.is_capturing.clear()
    videos[0].images.put(1)
    assert videos[0].closed.wait(PATIENCE) and len(videos) == 1
    driver.is_capturing.set()
    until(lambda: len(videos) == 2)
    finish(node, videos[1])
    other = make_node("usb_cam2", argv=["_video_device:=/dev/null"])
    start_usb_cam(other)
    peer.service("/usb_cam2/stop_capture", Empty)()
    peer.service("/usb_cam2/start_capture", Empty)()


def test_unknown_pixel_formats(make_node: Callable[..., Any]) -> None:
    with pytest.raises(SettingError, match="the pixel format 'yuvmono10' is unknown: ~pixel_format is one of yuyv"):
        start_usb_cam(make_node("usb_cam", argv=["_pixel_format:=yuvmono10"]))


@pytest.mark.skipif(find_spec("av") is None, reason="the extra `video` brings it")
class TestWithPyAv:
    """Videos by libav."""

    def test_a_video_of_libav(self) -> None:
        video = AvVideo("testsrc=size=64x48:rate=30:duration=0.1", "lavfi", {}, "rgb24")
        first = video.read(True)
        assert first is not None and first.shape == (48, 64, 3)
        assert video.read(False) is None and video.read(True) is not None
        with pytest.raises(VideoEndedError, match="has ended"):
            video.read(True)
        video.close()

    @pytest.mark.parametrize("source", ["/dev/video99", "/dev/null"])
    def test_devices_that_are_no_cameras(self, source: str) -> None:
        with pytest.raises(VideoError, match=source):
            AvVideo(source, "v4l2", {"video_size": "640x480"}, "rgb24")

    def test_a_file_is_published_at_the_rate_and_then_ends(
        self,
        make_node: Callable[..., Any],
        until: Callable[..., None],
        tmp_path: Path,
        capfd: Any,
        monkeypatch: pytest.MonkeyPatch,
    ) -> None:
        import av

        path = tmp_path / "film.avi"
        with av.open(str(path), "w") as film:
            stream = film.add_stream("mjpeg", rate=30, width=64, height=48, pix_fmt="yuvj420p")
            for shade in range(8):
                frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), 30 * shade, "u1"), format="bgr24")
                film.mux(stream.encode(frame))
            film.mux(stream.encode())
        peer = make_node("peer")
        images = listen(peer, "/cv_camera/image_raw", Image)
        node = make_node("cv_camera", argv=[f"_file:={path}", "_rate:=50", "_frame_id:=film"])

        def open_when_connected(*args: Any) -> AvVideo:
            until(lambda: peer_is_connected(node, "/cv_camera/image_raw"))
            return AvVideo(*args)

        monkeypatch.setattr("pyros1.robot_nodes.usb_cam.programs.AvVideo", open_when_connected)
        start_cv_camera(node)
        image = images.get(timeout=PATIENCE)
        assert (image.encoding, image.height, image.width, image.header.frame_id) == ("bgr8", 48, 64, "film")
        said = ""

        def has_ended() -> bool:
            nonlocal said
            said += capfd.readouterr().out
            return "film.avi has ended" in said

        until(has_ended)


def test_images_come_although_simulated_time_has_not_begun(
    make_node: Callable[..., Any], until: Callable[..., None]
) -> None:
    video, peer = FakeVideo(), make_node("peer")
    peer.params["/use_sim_time"] = True
    node = make_node("cv_camera")
    infos = listen(peer, "/cv_camera/camera_info", CameraInfo)
    CameraDriver(node, replace(OPTIONS, delay=0.1), lambda: video)
    assert feed_until(video, infos, until).header.stamp.to_nsec() == 0
    finish(node, video)


def test_a_calibration_without_a_size_does_not_end_the_camera(
    make_node: Callable[..., Any], until: Callable[..., None], tmp_path: Path
) -> None:
    video, node, peer = FakeVideo(), make_node("cv_camera"), make_node("peer")
    images = listen(peer, "/cv_camera/image_raw", Image)
    options = replace(OPTIONS, url=f"file://{tmp_path}/lens.yaml", rescale=True)
    CameraDriver(node, options, lambda: video)
    feed_until(video, images, until)
    info = CameraInfo(distortion_model="plumb_bob")
    info.K = [1.0, *[0.0] * 8]
    assert peer.service("/cv_camera/set_camera_info", SetCameraInfo)(info).success
    for _ in range(3):
        feed_until(video, images, until)
    finish(node, video)
