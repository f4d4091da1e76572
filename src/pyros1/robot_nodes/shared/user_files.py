"""Reads files that users specify in parameters, arguments and service requests, and numbers in such files."""

from __future__ import annotations

import errno
import os
import re
import stat
from math import isfinite

from pyros1.robot_nodes.shared.parameters import is_number

_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_MAX_NUMBER_LENGTH = 100


def read_regular_file(path: str, max_bytes: int) -> bytes:
    """Return the content of a file, up to a number of bytes.

    Args:
        path: the file. Pipes and devices are rejected: reading them could take forever, or have side effects.
        max_bytes: maximum number of bytes to read.

    Raises:
        OSError: the path is not that of a regular file, or the file cannot be read.
        ValueError: the path contains a null byte.
    """
    mode = os.stat(path).st_mode  # before opening it, since even opening some devices has side effects
    if not stat.S_ISREG(mode):
        number = errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL
        reason = os.strerror(number) if stat.S_ISDIR(mode) else "It is not a regular file, but a pipe or a device"
        raise OSError(number, reason, path)
    # Without O_NONBLOCK, this would block if the file has become a pipe meanwhile.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with open(descriptor, "rb") as file:
        return file.read(max_bytes)


def yaml_number(value: object) -> float | None:
    """Convert a value from a YAML file to a finite number; None if it is not one.

    Args:
        value: a value that PyYAML has read. PyYAML reads 1e-05 as a string, since YAML 1.1 requires 1.0e-05; but C++
            and other programs write numbers in this way, and yaml-cpp reads them.
    """
    if isinstance(value, str) and len(value) <= _MAX_NUMBER_LENGTH and _NUMBER.fullmatch(value):
        number = float(value)
        return number if isfinite(number) else None
    return float(value) if is_number(value) else None
