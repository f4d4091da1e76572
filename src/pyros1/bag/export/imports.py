"""Imports MCAP files and ROS 2 bags, choosing a reader by the type of the file."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from pyros1.bag.errors import BagError
from pyros1.bag.export.import_result import ImportResult


def import_bag(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    *,
    compression: str = "none",
    is_selected: Callable[[str], bool] = lambda topic: True,
    progress: Callable[[int], object] | None = None,
) -> ImportResult:
    """Convert a ROS 2 bag, or an MCAP file with ROS 1 or ROS 2 messages, to a bag.

    ROS 1 messages are copied unchanged. ROS 2 types that are also installed as ROS 1 types get the installed definition
    and md5 sum; fields that differ are matched by name and type. All other types keep their own definition.

    Args:
        source: a folder with ``metadata.yaml``, an ``.mcap`` or a ``.db3`` file.
        target: the new bag; replaced if it exists.
        compression: ``none``, ``bz2`` or ``lz4``.
        is_selected: returns whether to import a topic.
        progress: called with the number of bytes processed so far.

    Raises:
        BagError: the source cannot be read or converted.
        OSError: a file cannot be opened or written.
    """
    path = Path(source)
    if not path.exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    if path.is_fifo():  # opening it would block forever
        raise BagError(str(path), "this is a pipe; bags can only be read from files")
    if path.is_dir() and not (path / "metadata.yaml").exists():
        raise BagError(str(path), "this is not a ROS 2 bag: the folder has no metadata.yaml")
    if path.is_file() and path.suffix not in (".mcap", ".db3"):
        raise BagError(str(path), "this is neither the folder of a ROS 2 bag nor an .mcap or .db3 file")
    from pyros1.bag.export.mcap_reader import McapReader  # noqa: PLC0415 - not always needed

    if path.is_file() and path.suffix == ".mcap":
        with McapReader(path) as reader:
            if reader.profile != "ros2":
                from pyros1.bag.export.from_mcap import import_ros1  # noqa: PLC0415 - not always needed

                return import_ros1(reader, target, compression=compression, is_selected=is_selected, progress=progress)
    for file in sorted(path.glob("*.mcap")) if path.is_dir() else [path] if path.suffix == ".mcap" else []:
        with McapReader(file) as reader:
            reader.check()  # since rosbags does not check its input
    from pyros1.bag.export.from_ros2 import import_ros2  # noqa: PLC0415 - rosbags is slow to load, and not always needed

    return import_ros2(path, target, compression=compression, is_selected=is_selected, progress=progress)
