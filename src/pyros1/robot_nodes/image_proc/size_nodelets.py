"""The nodes resize and crop_decimate (https://wiki.ros.org/image_proc)."""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.node import Node
from pyros1.reconfigure import Parameters, Server
from pyros1.robot_nodes.image_proc.inputs import Ending, subscribe_camera
from pyros1.robot_nodes.image_proc.nodelets import QUIET
from pyros1.robot_nodes.image_proc.pixels import ImageError
from pyros1.robot_nodes.image_proc.resample import LINEAR, METHODS, NEAREST
from pyros1.robot_nodes.image_proc.sizes import CROP_METHODS, Crop, Scaling
from pyros1.robot_nodes.shared.lazy import LazyInputs

_MAX_SIZE = 2**31 - 1


class Resize:
    """Converts ``image`` and ``camera_info`` to ``~image`` and ``~camera_info``.

    Args:
        node: the node, whose private parameters configure it.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        parameters = Parameters()
        parameters.add("interpolation", LINEAR, "interpolation algorithm", minimum=0, maximum=4, choices=METHODS)
        parameters.add("use_scale", True, "whether scale_height and scale_width count, or height and width")
        parameters.add("scale_height", 1.0, "factor of the height", minimum=0.0, maximum=10.0)
        parameters.add("scale_width", 1.0, "factor of the width", minimum=0.0, maximum=10.0)
        parameters.add("height", -1, "new height; -1 for the image's", minimum=-1, maximum=_MAX_SIZE)
        parameters.add("width", -1, "new width; -1 for the image's", minimum=-1, maximum=_MAX_SIZE)
        self._scaling = Scaling()
        self._server = Server(node, parameters, self._on_configured)
        self._images = node.advertise("~image", Image, queue_size=1)
        self._infos = node.advertise("~camera_info", CameraInfo, queue_size=1)
        self._lazies = [
            LazyInputs([self._images], self._subscribe_images),
            LazyInputs([self._infos], self._subscribe_infos),
        ]

    def _on_configured(self, config: Any, level: int) -> Any:
        self._scaling = Scaling(
            config.use_scale,
            config.scale_width,
            config.scale_height,
            config.width,
            config.height,
            config.interpolation,
        )
        return config

    def _subscribe_images(self) -> list[Ending]:
        return [self._node.subscribe("image", Image, self._receive_image, queue_size=1).unregister]

    def _subscribe_infos(self) -> list[Ending]:
        return [self._node.subscribe("camera_info", CameraInfo, self._receive_info, queue_size=1).unregister]

    def _receive_image(self, image: Any) -> None:
        try:
            self._images.publish(self._scaling.apply_to_image(image))
        except (ImageError, MessageError) as error:
            self._node.log.error("%s: %s", self._node.resolve("image"), error, throttle=QUIET)

    def _receive_info(self, info: Any) -> None:
        try:
            self._infos.publish(self._scaling.apply_to_info(info))
        except (ImageError, MessageError) as error:
            self._node.log.error("%s: %s", self._node.resolve("camera_info"), error, throttle=QUIET)


class CropDecimate:
    """Converts ``camera/image_raw`` and its ``camera_info`` to ``camera_out/image_raw`` and its ``camera_info``.

    Args:
        node: the node, whose private parameters configure it.
        queue_size: maximum number of images, and of camera_infos, that wait for their counterparts.
    """

    def __init__(self, node: Node, queue_size: int) -> None:
        self._node, self._queue_size = node, queue_size
        parameters = Parameters()
        parameters.add("decimation_x", 1, "columns that become one", minimum=1, maximum=16)
        parameters.add("decimation_y", 1, "rows that become one", minimum=1, maximum=16)
        parameters.add("x_offset", 0, "first column", minimum=0, maximum=2447)
        parameters.add("y_offset", 0, "first row", minimum=0, maximum=2049)
        parameters.add("width", 0, "columns of the part; 0 for all", minimum=0, maximum=2448)
        parameters.add("height", 0, "rows of the part; 0 for all", minimum=0, maximum=2050)
        parameters.add("interpolation", NEAREST, "sampling algorithm", minimum=0, maximum=4, choices=CROP_METHODS)
        self._crop = Crop()
        self._server = Server(node, parameters, self._on_configured)
        # As in stock ROS, the names of the two namespaces are remapped, not those of the topics.
        self._source = f"{node.resolve('camera')}/image_raw"
        target = node.resolve("camera_out")
        self._images = node.advertise(f"{target}/image_raw", Image, queue_size=1)
        self._infos = node.advertise(f"{target}/camera_info", CameraInfo, queue_size=1)
        self._lazy = LazyInputs([self._images, self._infos], self._subscribe)

    def _on_configured(self, config: Any, level: int) -> Any:
        self._crop = Crop(**{name: config[name] for name in Crop.__dataclass_fields__})
        return config

    def _subscribe(self) -> list[Ending]:
        return subscribe_camera(self._node, self._source, self._receive, self._queue_size)

    def _receive(self, image: Any, info: Any) -> None:
        try:
            image, info = self._crop.apply(image, info)
            self._images.publish(image)
            self._infos.publish(info)
        except (ImageError, MessageError) as error:
            self._node.log.error("%s: %s", self._source, error, throttle=2.0)
