"""Bags from files of others: who reads which."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from pyros1.bag.errors import BagError
from pyros1.bag.export.imported import Imported


def import_bag(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    *,
    compression: str = "none",
    wanted: Callable[[str], bool] = lambda topic: True,
    progress: Callable[[int], object] | None = None,
) -> Imported:
    """Make a bag of a ROS 2 bag, or of an MCAP file with messages of ROS 1 or ROS 2.

    Messages of ROS 1 are copied as they are. Of ROS 2, types that are known here get their ROS 1 definition and md5
    sum, and fields that differ are matched by name and type; other types are defined as the source says.

    Args:
        source: a folder with ``metadata.yaml``, an ``.mcap`` or a ``.db3`` file.
        target: the new bag; replaced if it exists.
        compression: ``none``, ``bz2`` or ``lz4``.
        wanted: says whether a topic is.
        progress: called with the number of bytes done.

    Raises:
        BagError: the source cannot be read, or holds what cannot be converted.
        OSError: a file cannot be opened or written.
    """
    path = Path(source)
    if not path.exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    if path.is_fifo():  # opening it would wait for ever
        raise BagError(str(path), "this is a pipe; bags are read from files")
    if path.is_dir() and not (path / "metadata.yaml").exists():
        raise BagError(str(path), "the folder holds no metadata.yaml, so that it is no ROS 2 bag")
    if path.is_file() and path.suffix not in (".mcap", ".db3"):
        raise BagError(str(path), "this is neither a ROS 2 bag's folder nor an .mcap or .db3 file")
    from pyros1.bag.export.mcap_reader import McapReader  # noqa: PLC0415 - as below

    if path.is_file() and path.suffix == ".mcap":
        with McapReader(path) as reader:
            if reader.profile != "ros2":
                from pyros1.bag.export.from_mcap import import_ros1  # noqa: PLC0415 - as below

                return import_ros1(reader, target, compression=compression, wanted=wanted, progress=progress)
    for file in sorted(path.glob("*.mcap")) if path.is_dir() else [path] if path.suffix == ".mcap" else []:
        with McapReader(file) as reader:
            reader.check()  # since rosbags believes all that it reads
    from pyros1.bag.export.from_ros2 import import_ros2  # noqa: PLC0415 - rosbags is slow to load, and not always needed

    return import_ros2(path, target, compression=compression, wanted=wanted, progress=progress)
