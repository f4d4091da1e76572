"""Rebuilds a bag's index without using the old index."""

from __future__ import annotations

import os
import tempfile

from pyros1.bag.edit.reindex import reindex
from pyros1.bag.format.appending import open_for_append
from pyros1.bag.format.writer import BagWriter
from rosbag._types import ROSBagException


def rebuild_index(path: str | None, writer: BagWriter | None, compression: str, threshold: int) -> BagWriter:
    """Replace a bag's file with one that has all its messages and a new index; return a writer that appends to it.

    Args:
        path: path of the file.
        writer: the writer that has the file open, and is closed here; None if there is none.
        compression, threshold: compression and chunk threshold of the new writer.

    Raises:
        ROSBagException: the bag is a file object.
    """
    if writer is not None:
        writer.close()
    if path is None:
        raise ROSBagException("pyros1 reindexes bags in files only, not in file objects")
    with tempfile.TemporaryDirectory(dir=os.path.dirname(os.path.abspath(path))) as folder:
        new_path = os.path.join(folder, "part.bag")
        reindex(path, new_path)
        os.replace(new_path, path)
    return open_for_append(path, compression, threshold)
