"""The nodes debayer and rectify (https://wiki.ros.org/image_proc): colour, grey and rectified images.

Each has its own namespace for parameters, since ``image_proc`` runs several of them in one node.
"""

from __future__ import annotations

from typing import Any

from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.node import Node
from pyros1.reconfigure import Parameters, Server
from pyros1.robot_nodes.image_proc.camera import Camera, UncalibratedError, is_undistorted
from pyros1.robot_nodes.image_proc.colours import to_bgr, to_mono
from pyros1.robot_nodes.image_proc.inputs import Ending, info_topic, subscribe_camera
from pyros1.robot_nodes.image_proc.pixels import ImageError, parse_encoding, to_array, to_image
from pyros1.robot_nodes.image_proc.remap import LINEAR, NEAREST, Remap
from pyros1.robot_nodes.image_proc.resample import METHODS
from pyros1.robot_nodes.shared.lazy import LazyInputs

QUEUE_SIZE = 5
QUIET = 30.0
"""Seconds until the same problem is logged again, as in stock ROS."""
_BILINEAR = 0
_ALGORITHMS = {"Bilinear": _BILINEAR, "EdgeAware": 1, "EdgeAwareWeighted": 2, "VNG": 3}


class Debayer:
    """Converts ``image_raw`` to ``image_mono`` and ``image_color``.

    Args:
        node: the node.
        namespace: the namespace of its parameter ``debayer``.
    """

    def __init__(self, node: Node, namespace: str = "~") -> None:
        self._node = node
        self._topic = node.resolve("image_raw")
        parameters = Parameters()
        parameters.add("debayer", _BILINEAR, "debayering algorithm", minimum=0, maximum=3, choices=_ALGORITHMS)
        self._server = Server(node, parameters, self._on_configured, namespace=namespace)
        self._mono, self._colour = (node.advertise(f"image_{name}", Image, queue_size=1) for name in ("mono", "color"))
        self._lazy = LazyInputs([self._mono, self._colour], self._subscribe)

    def _on_configured(self, config: Any, level: int) -> Any:
        if config.debayer != _BILINEAR:
            self._node.log.warn("debayer: only Bilinear (0) is available, and is used instead of %d", config.debayer)
        return config

    def _subscribe(self) -> list[Ending]:
        return [self._node.subscribe(self._topic, Image, self._receive, queue_size=1).unregister]

    def _receive(self, image: Any) -> None:
        try:
            encoding = parse_encoding(image.encoding)
            if self._mono.num_connections:
                self._publish_mono(image, encoding)
            if self._colour.num_connections:
                self._publish_colour(image, encoding)
        except ImageError as error:
            self._node.log.error("%s: %s", self._topic, error, throttle=QUIET)

    def _publish_mono(self, image: Any, encoding: Any) -> None:
        if not encoding.is_mono:
            image = to_image(image.header, *to_mono(to_array(image), encoding))
        self._mono.publish(image)

    def _publish_colour(self, image: Any, encoding: Any) -> None:
        if encoding.is_mono:
            text = "%s is wanted in color, but the images on %s have none: they are passed on as they are"
            self._node.log.warn(text, self._colour.name, self._topic, throttle=QUIET)
        elif encoding.bayer or encoding.is_yuv:
            image = to_image(image.header, *to_bgr(to_array(image), encoding))
        elif not encoding.is_colour:
            raise ImageError(f"the encoding {encoding.name} does not say what its colours are: publish bgr8 or rgb8")
        self._colour.publish(image)


class Rectify:
    """Publishes rectified images, computed from images and their ``camera_info``.

    Args:
        node: the node.
        namespace: the namespace of its parameter ``interpolation``.
        source, target: the topics of the images.
        queue_size: maximum number of images, and of camera_infos, that wait for their counterparts.
    """

    def __init__(
        self,
        node: Node,
        namespace: str = "~",
        source: str = "image_mono",
        target: str = "image_rect",
        queue_size: int = QUEUE_SIZE,
    ) -> None:
        self._node = node
        self._source, self._queue_size = source, queue_size
        self._remap: Remap | None = None
        self._remap_is_for: tuple[Camera, int] | None = None  # camera and interpolation
        self._interpolation = LINEAR
        parameters = Parameters()
        parameters.add("interpolation", LINEAR, "interpolation algorithm", minimum=0, maximum=4, choices=METHODS)
        self._server = Server(node, parameters, self._on_configured, namespace=namespace)
        self._publisher = node.advertise(target, Image, queue_size=1)
        self._lazy = LazyInputs([self._publisher], self._subscribe)

    def _on_configured(self, config: Any, level: int) -> Any:
        if config.interpolation not in (NEAREST, LINEAR):
            text = "rectify: only NN (0) and Linear (1) are available; Linear is used instead of %d"
            self._node.log.warn(text, config.interpolation)
        self._interpolation = NEAREST if config.interpolation == NEAREST else LINEAR
        return config

    def _subscribe(self) -> list[Ending]:
        return subscribe_camera(self._node, self._source, self._receive, self._queue_size)

    def _receive(self, image: Any, info: Any) -> None:
        try:
            self._publisher.publish(self._rectified(image, info))
        except UncalibratedError as error:
            self._log("%s is wanted, but %s", self._publisher.name, error)
        except ImageError as error:
            self._log("%s: %s", self._node.resolve(self._source), error)

    def _log(self, text: str, *args: object) -> None:
        self._node.log.error(f"{text} (%s)", *args, info_topic(self._node, self._source), throttle=QUIET)

    def _rectified(self, image: Any, info: Any) -> Any:
        if info.K[0] and is_undistorted(info):
            return image  # not even copied, as in stock ROS
        camera = Camera.from_info(info)
        if camera.size != (image.height, image.width):
            raise ImageError(
                f"the image has {image.width} x {image.height} pixels, but with camera_info it should have "
                f"{camera.size[1]} x {camera.size[0]}"
            )
        encoding = parse_encoding(image.encoding)
        if encoding.bayer or encoding.is_yuv:
            raise ImageError(
                f"images with the encoding {encoding.name} cannot be rectified: take image_color or image_mono"
            )
        pixels = to_array(image)
        remap, wanted = self._remap, (camera, self._interpolation)  # read once: a callback may change it
        if remap is None or self._remap_is_for != wanted:
            remap = self._remap = Remap(*camera.source_positions(), camera.size, wanted[1])
            self._remap_is_for = wanted
        return to_image(image.header, remap.apply(pixels), image.encoding)
