"""Rebuilds a bag's index without the old one."""

from __future__ import annotations

import os
import tempfile

from pyros1.bag.edit.reindex import reindex
from pyros1.bag.format.appending import append
from pyros1.bag.format.writer import BagWriter
from rosbag._parts import ROSBagException


def repaired(path: str | None, writer: BagWriter | None, compression: str, threshold: int) -> BagWriter:
    """Replace a file by one with all of its messages and a new index; return the writer that continues with it.

    Args:
        path: of the file.
        writer: the one that has it open, if any; it is closed.
        compression, threshold: of the new writer.

    Raises:
        ROSBagException: the bag is a file object.
    """
    if writer is not None:
        writer.close()
    if path is None:
        raise ROSBagException("pyros1 reindexes bags in files only, not in file objects")
    with tempfile.TemporaryDirectory(dir=os.path.dirname(os.path.abspath(path))) as folder:
        part = os.path.join(folder, "part.bag")
        reindex(path, part)
        os.replace(part, path)
    return append(path, compression, threshold)
