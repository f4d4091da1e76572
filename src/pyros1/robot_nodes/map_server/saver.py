"""map_saver: waits for a map and saves it (https://wiki.ros.org/map_server#map_saver)."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from pyros1.ground.errors import Error, NodeShutdownError
from pyros1.msgs.nav_msgs.msg import OccupancyGrid
from pyros1.node import Node
from pyros1.robot_nodes.map_server.cells import to_pixels
from pyros1.robot_nodes.map_server.description import format_description
from pyros1.robot_nodes.map_server.errors import MapError
from pyros1.robot_nodes.map_server.messages import read_grid
from pyros1.robot_nodes.map_server.pgm import write_pgm


def save_map(message: Any, name: str, occupied: int = 65, free: int = 25) -> tuple[str, str]:
    """Save a map as NAME.pgm and NAME.yaml, which map_server reads; return the two paths.

    Args:
        message: a nav_msgs/OccupancyGrid.
        name: path of the files, without extension.
        occupied: the lowest value of occupied cells.
        free: the highest value of free cells; the others are unknown.

    Raises:
        MapError: the message is invalid, or a file cannot be written.
    """
    cells, origin = read_grid(message)
    resolution = message.info.resolution
    picture, description = f"{name}.pgm", f"{name}.yaml"
    pixels = to_pixels(cells, free, occupied)
    _write(picture, write_pgm(pixels, f"CREATOR: map_saver of pyros1 {resolution:.3f} m/pix"))
    # Without the folder: the original writes the path, so a map saved in another folder can only be loaded from there.
    _write(description, format_description(os.path.basename(picture), resolution, origin).encode())
    return picture, description


def _write(path: str, data: bytes) -> None:
    part = f"{path}.part"
    try:
        with open(part, "wb") as file:
            file.write(data)
        os.replace(part, path)  # keeps an earlier map until the new one is complete
    except OSError as error:
        raise MapError(f"{path} cannot be written: {error.strerror}") from None


def _parse(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="map_saver", description="Save the next map on the topic map.")
    parser.add_argument("-f", dest="name", metavar="NAME", default="map", help="write NAME.pgm and NAME.yaml (map)")
    parser.add_argument("--occ", type=int, default=65, help="cells of at least this are occupied: 1 ... 100 (65)")
    parser.add_argument("--free", type=int, default=25, help="cells up to this are free: 0 ... 100 (25)")
    options = parser.parse_args(words)
    if not 1 <= options.occ <= 100:
        parser.error("--occ must be between 1 and 100")
    if not 0 <= options.free <= 100:
        parser.error("--free must be between 0 and 100")
    if options.free >= options.occ:
        parser.error("--free must be smaller than --occ")
    return options


def main(argv: list[str]) -> int:
    """Run map_saver; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    options = _parse([word for word in argv[1:] if ":=" not in word])
    with Node("map_saver", argv=argv[1:]) as node:
        node.log.info("Waiting for the map on %s", node.resolve("map"))
        try:
            message = node.wait_for_message("map", OccupancyGrid)
            info = message.info
            node.log.info("Received a %d X %d map @ %.3f m/pix", info.width, info.height, info.resolution)
            for path in save_map(message, options.name, options.occ, options.free):
                node.log.info("Wrote %s", path)
        except NodeShutdownError:
            sys.stderr.write("map_saver: no map was saved\n")
            return 1
        except Error as error:
            node.log.fatal("%s", error)
            return 1
    return 0
