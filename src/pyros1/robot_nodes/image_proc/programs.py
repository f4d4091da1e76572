"""The programs of image_proc (https://wiki.ros.org/image_proc).

``image_proc`` runs one debayer and two rectify nodelets in a single node; each of the other programs runs one nodelet,
like ``nodelet standalone image_proc/NAME`` in stock ROS.
"""

from __future__ import annotations

from typing import Any

from pyros1.node import Node
from pyros1.robot_nodes.image_proc.nodelets import QUEUE_SIZE, Debayer, Rectify
from pyros1.robot_nodes.image_proc.size_nodelets import CropDecimate, Resize
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node

PATIENCE = 60.0
"""Seconds after which a missing input is reported once, as in stock ROS."""


def start_image_proc(node: Node) -> list[Any]:
    """Start the nodelets that publish ``image_mono``, ``image_color``, ``image_rect`` and ``image_rect_color``."""
    if node.resolve("camera") != node.resolve("camera", remap=False):
        node.log.warn("remapping camera has no effect: start image_proc in the namespace %s", node.resolve("camera"))
    if node.namespace == "/":
        node.log.warn(
            "image_proc runs in the global namespace, which is probably wrong; start it in the camera's: "
            "ROS_NAMESPACE=my_camera pyros1 run image_proc image_proc"
        )
    queue_size = _queue_size(node)
    return [
        Debayer(node, f"{node.name}_debayer"),
        Rectify(node, f"{node.name}_rectify_mono", queue_size=queue_size),
        Rectify(node, f"{node.name}_rectify_color", "image_color", "image_rect_color", queue_size),
        node.timer(PATIENCE, lambda event: _report_missing(node), oneshot=True),
    ]


def _queue_size(node: Node) -> int:
    params = PrivateParameters.of(node)
    transport = params.text("image_transport", "raw")
    if transport != "raw":
        node.log.warn(
            "image_transport=%s: only raw images are received; pyros1 run image_transport republish converts others",
            transport,
        )
    return params.integer("queue_size", QUEUE_SIZE, 1, 10000)


def _report_missing(node: Node) -> None:
    published = {topic for topic, _ in node.master.get_published_topics()}
    missing = [topic for topic in map(node.resolve, ("image_raw", "camera_info")) if topic not in published]
    if missing:
        text = "nobody publishes %s: is the camera's node running, and is this the namespace of its topics?"
        node.log.warn(text, " and ".join(missing))


def main(argv: list[str]) -> int:
    """Run image_proc; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "image_proc", start_image_proc)


def main_debayer(argv: list[str]) -> int:
    """Run debayer; see `main`."""
    return run_node(argv, "debayer", Debayer)


def main_rectify(argv: list[str]) -> int:
    """Run rectify; see `main`."""
    return run_node(argv, "rectify", lambda node: Rectify(node, queue_size=_queue_size(node)))


def main_resize(argv: list[str]) -> int:
    """Run resize; see `main`."""
    return run_node(argv, "resize", Resize)


def main_crop_decimate(argv: list[str]) -> int:
    """Run crop_decimate; see `main`."""
    return run_node(argv, "crop_decimate", lambda node: CropDecimate(node, _queue_size(node)))
