"""What a CameraInfo says of a camera. The numbers are those of stock's image_geometry for the same messages."""

from __future__ import annotations

import math

import pytest

from pyros1.msgs.sensor_msgs.msg import CameraInfo, RegionOfInterest
from pyros1.web.scene.camera import Camera, camera_info_topic, pinhole_camera
from pyros1.web.scene.shape import ShapeError

K = [525.0, 0.0, 319.5, 0.0, 520.0, 239.5, 0.0, 0.0, 1.0]
P = [500.0, 0.0, 310.5, -50.0, 0.0, 510.0, 240.5, 0.0, 0.0, 0.0, 1.0, 0.0]
PART = RegionOfInterest(x_offset=100, y_offset=50, width=300, height=200)


def info(**more: object) -> CameraInfo:
    return CameraInfo(**{"width": 640, "height": 480, "K": K, "P": P, **more})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("message", "numbers"),
    [
        (info(), (500.0, 510.0, 310.5, 240.5, 640, 480)),
        (info(binning_x=2, binning_y=2), (250.0, 255.0, 155.25, 120.25, 320, 240)),
        (info(binning_x=1, binning_y=4), (500.0, 127.5, 310.5, 60.125, 640, 120)),
        (info(roi=PART), (500.0, 510.0, 210.5, 190.5, 300, 200)),
        (info(roi=PART, binning_x=2, binning_y=2), (250.0, 255.0, 105.25, 95.25, 150, 100)),
    ],
)
def test_parts_of_pictures_and_binning(message: CameraInfo, numbers: tuple[float, ...]) -> None:
    camera = pinhole_camera(message)
    assert (camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height) == numbers
    assert (camera.tx, camera.ty) == (0.1, 0.0)  # of the right one of two cameras


def test_without_a_projection_matrix_k_counts() -> None:
    camera = pinhole_camera(info(P=[0.0] * 12))
    assert (camera.fx, camera.fy, camera.cx, camera.cy, camera.tx, camera.ty) == (525.0, 520.0, 319.5, 239.5, 0, 0)


@pytest.mark.parametrize(
    "rows",
    [
        [0.0] * 12,
        [math.nan] * 12,
        [-1.0, *P[1:]],
        [*P[:5], 0.0, *P[6:]],
        [5e-324, *P[1:]],
        [*P[:3], -1e300, *P[4:]],
    ],
)
def test_cameras_that_are_not_calibrated(rows: list[float]) -> None:
    with pytest.raises(ShapeError, match="not calibrated"):
        pinhole_camera(info(P=rows, K=[0.0] * 9))


@pytest.mark.parametrize(("place", "number"), [(0, 1e-300), (2, 1e300), (3, -1e200), (5, 5e-324), (7, 1.7e308)])
def test_absurd_cameras_are_not_calibrated(place: int, number: float) -> None:
    with pytest.raises(ShapeError, match="not calibrated"):
        pinhole_camera(info(P=[number if index == place else value for index, value in enumerate(P)]))


def test_pictures_of_another_size() -> None:
    camera = Camera(500.0, 510.0, 319.5, 239.5, 0.0, 0.0, 640, 480)
    assert camera.resized(640, 480) is camera
    assert camera.resized(320, 120) == Camera(250.0, 127.5, 159.5, 59.5, 0.0, 0.0, 320, 120)
    assert Camera(500.0, 510.0, 9.0, 9.0, 0, 0, 0, 0).resized(20, 20) == Camera(500.0, 510.0, 9.0, 9.0, 0, 0, 20, 20)


def test_where_the_camera_info_of_a_topic_is() -> None:
    assert camera_info_topic("/camera/image_raw") == "/camera/camera_info"
    assert camera_info_topic("/image") == "/camera_info"
    assert camera_info_topic("/camera/image_raw/compressed", compressed=True) == "/camera/camera_info"
