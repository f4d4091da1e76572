"""map_server: publishes a map from an image (https://wiki.ros.org/map_server#map_server)."""

from __future__ import annotations

import os
import sys
from math import isfinite
from typing import Any
from urllib.parse import unquote

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.nav_msgs.msg import MapMetaData, OccupancyGrid
from pyros1.msgs.nav_msgs.srv import GetMap, LoadMap
from pyros1.node import Node
from pyros1.robot_nodes.map_server.description import Description
from pyros1.robot_nodes.map_server.errors import MapDataError, MapMetadataError, MapMissingError
from pyros1.robot_nodes.map_server.loading import Map, load_map, load_picture
from pyros1.robot_nodes.map_server.messages import make_grid
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node

USAGE = """\
usage: map_server MAP.yaml
       map_server IMAGE RESOLUTION   (m per pixel; the parameters ~negate, ~occupied_thresh and ~free_thresh count)
"""
_RESULTS = (
    (MapMissingError, LoadMap._response_class.RESULT_MAP_DOES_NOT_EXIST),
    (MapDataError, LoadMap._response_class.RESULT_INVALID_MAP_DATA),
    (MapMetadataError, LoadMap._response_class.RESULT_INVALID_MAP_METADATA),
    (Error, LoadMap._response_class.RESULT_UNDEFINED_FAILURE),
)


class MapServer:
    """Publishes a map on ``map`` and ``map_metadata``, latched, and provides ``static_map`` and ``change_map``.

    Args:
        node: the node; its parameter ``~frame_id`` is the map's frame.
        first: the map to publish first.
    """

    def __init__(self, node: Node, first: Map) -> None:
        self._node = node
        self._frame = PrivateParameters.of(node).text("frame_id", "map")
        self._metadata_publisher = node.advertise("map_metadata", MapMetaData, queue_size=1, latch=True)
        self._publisher = node.advertise("map", OccupancyGrid, queue_size=1, latch=True)
        self._grid = self._publish(first)
        node.advertise_service("static_map", GetMap, self._on_get)
        node.advertise_service("change_map", LoadMap, self._on_change)

    def _publish(self, loaded: Map) -> Any:
        grid = make_grid(*loaded)
        grid.header.frame_id = self._frame
        grid.header.stamp = grid.info.map_load_time = self._node.now()
        self._metadata_publisher.publish(grid.info)
        self._publisher.publish(grid)
        size = (grid.info.width, grid.info.height, grid.info.resolution)
        self._node.log.info("Read a %d X %d map @ %.3lf m/cell", *size)
        return grid

    def _on_get(self, request: Any) -> Any:
        self._node.log.info("Sending map")
        return GetMap._response_class(self._grid)

    def _on_change(self, request: Any) -> Any:
        response = LoadMap._response_class()
        try:
            self._grid = self._publish(load_map(_path_of(request.map_url, self._node)))
        except Error as error:
            self._node.log.error("the map is not changed: %s", error)
            response.result = next(code for error_class, code in _RESULTS if isinstance(error, error_class))
        else:
            response.map = self._grid
        return response


def _path_of(url: str, node: Node) -> str:
    """Return the file of a map's URL: a path, file:///PATH or package://PACKAGE/PATH."""
    scheme, separator, rest = url.partition("://")
    if not separator:
        return url
    if scheme == "file":
        return unquote(rest)
    if scheme != "package":
        raise MapMissingError(f"{one_line(url, 200)}: only file:// and package:// can be read")
    package, _, path = unquote(rest).partition("/")
    return os.path.join(PackageIndex(node.environ).find_folder(package), path)


def _first_map(node: Node) -> Map:
    words = node.arguments.rest
    if len(words) == 1:
        return load_map(words[0])
    try:
        path, resolution = words[0], float(words[1])
    except ValueError:
        resolution = -1.0
    if not (isfinite(resolution) and resolution > 0):
        raise Error(f"RESOLUTION must be a positive number (metres per pixel), not {one_line(words[1], 100)!r}")
    node.log.warn("a map without YAML file is deprecated: write its resolution into MAP.yaml")
    values, defaults = PrivateParameters.of(node), Description(path, resolution)
    return load_picture(
        defaults._replace(
            negate=bool(values.integer("negate", 0)),
            occupied_thresh=values.number("occupied_thresh", defaults.occupied_thresh),
            free_thresh=values.number("free_thresh", defaults.free_thresh),
        )
    )


def main(argv: list[str]) -> int:
    """Run map_server; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    words = [word for word in argv[1:] if ":=" not in word]
    if not 1 <= len(words) <= 2 or words[0] in ("-h", "--help"):
        sys.stderr.write(USAGE)
        return int(words[:1] not in (["-h"], ["--help"]))
    return run_node(argv, "map_server", lambda node: MapServer(node, _first_map(node)), anonymous=True)
