"""extract_images_sync of Debian's image_view, unmodified, on stock's modules and on ours. It needs OpenCV, so both run
in the interpreter of the system, where OpenCV is; PYROS1_ROSPY prefers our modules to stock's."""

from __future__ import annotations

from pathlib import Path

import pytest
from faces import FACES, environ, start
from harness import STOCK_PYTHON, Master, Process

MASTERS = ("ours",)
COMMAND = [STOCK_PYTHON, "-u", "-W", "ignore", "/usr/lib/image_view/extract_images_sync"]
FORMAT = "_filename_format:=shot%i_%i.png"
CAMERAS = """
import sys
import numpy
import rospy
from sensor_msgs.msg import Image

rospy.init_node("cameras", anonymous=True)
cameras = [rospy.Publisher(name, Image, queue_size=30) for name in sys.argv[2:]]
while any(camera.get_num_connections() < 2 for camera in cameras):
    rospy.sleep(0.01)
dice = numpy.random.default_rng(5)
for number, (encoding, kind, channels) in enumerate(
    [("mono8", "u1", 1), ("8UC1", "u1", 1), ("32FC1", "f4", 1), ("16UC1", "u2", 1), ("bgr8", "u1", 3)]
):
    for index, camera in enumerate(cameras):
        if (number, index) == (2, 0):
            continue  # the other one's has no partner
        pixels = dice.integers(0, 200, 12 * 10 * channels).astype(kind)
        image = Image(height=12, width=10, encoding=encoding, step=len(pixels.tobytes()) // 12, data=pixels.tobytes())
        image.header.stamp = rospy.Time(100 + number, index * 50000000 if sys.argv[1] == "approximate" else 0)
        camera.publish(image)
print("sent", flush=True)
rospy.spin()
"""


def extractor(face: str, master: Master, folder: Path, *words: str) -> Process:
    """Start it in a folder of its own."""
    folder.mkdir()
    extra = {"PYROS1_ROSPY": "pyros1"} if face == "ours" else {}
    surroundings = {**environ(face, master, **extra)}
    process = Process(["env", "-C", str(folder), *COMMAND, *words, f"__name:=extractor_{face}"], surroundings)
    master.processes.append(process)
    return process


@pytest.mark.parametrize("mode", ["exact", "approximate"])
def test_pictures_of_two_cameras_are_saved_together(launcher: Master, tmp_path: Path, mode: str) -> None:
    topics = [f"/left_{mode}", f"/right_{mode}"]
    words = [FORMAT, f"_inputs:=[{', '.join(topics)}]", "_do_dynamic_scaling:=true"]
    words += ["_approximate_sync:=true"] if mode == "approximate" else []
    processes = [extractor(face, launcher, tmp_path / face, *words) for face in FACES]
    start("ours", launcher, CAMERAS, mode, *topics).wait_line("sent")
    for process in processes:
        process.wait_line("^RuntimeError")
    saved = []
    for face, process in zip(FACES, processes, strict=True):
        process.close()
        files = sorted((tmp_path / face).iterdir())
        lines = [line for line in process.lines if line.startswith(("Save", "RuntimeError"))]
        saved.append((lines, {file.name: file.read_bytes() for file in files}))
    assert saved[0] == saved[1]
    assert len(saved[0][1]) == 6
    assert any(
        "more than one channel" in line for line in saved[0][0]
    )  # of the last one, in colour: stock's stops there
