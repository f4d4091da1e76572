"""Opens joystick devices and reads them."""

from __future__ import annotations

import errno
import glob
import os
import stat
from collections.abc import Iterator
from contextlib import closing

DEVICES = "/dev/input/js*"
_READ_SIZE = 64 * 8
# Requests (ioctl) of linux/joystick.h. The first two read one byte; the last one reads _NAME_SIZE bytes.
_GET_AXES, _GET_BUTTONS = 0x80016A11, 0x80016A12
_NAME_SIZE = 128
_GET_NAME = 0x80006A13 | _NAME_SIZE << 16


class Device:
    """An open joystick.

    The path may also be a pipe or anything else that sends joystick events; the name and the numbers are then unknown.

    Args:
        path: the device.

    Attributes:
        path: the device.
        name: the name that the joystick reports; empty if unknown.
        axes, buttons: the numbers of axes and buttons; 0 if unknown.

    Raises:
        OSError: the device cannot be opened.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        mode = os.fstat(self._file).st_mode
        if not (stat.S_ISCHR(mode) or stat.S_ISFIFO(mode)):
            os.close(self._file)
            raise OSError(errno.ENODEV, "it is no device")
        self.name = self._ioctl(_GET_NAME, _NAME_SIZE).split(b"\0")[0].decode(errors="replace")
        self.axes = self._ioctl(_GET_AXES, 1)[0]
        self.buttons = self._ioctl(_GET_BUTTONS, 1)[0]

    def fileno(self) -> int:
        """Return the file descriptor, to wait for events."""
        return self._file

    def read(self) -> bytes:
        """Return bytes of events; none if there are no more at the moment.

        Raises:
            OSError: the device is gone, or cannot be read.
        """
        try:
            data = os.read(self._file, _READ_SIZE)
        except BlockingIOError:
            return b""
        if not data:
            raise OSError(errno.ENODEV, "it was closed")
        return data

    def close(self) -> None:
        """Close the device."""
        os.close(self._file)

    def _ioctl(self, request: int, size: int) -> bytes:
        import fcntl  # noqa: PLC0415 - Windows has neither this nor such devices

        answer = bytearray(size)
        try:
            fcntl.ioctl(self._file, request, answer)
        except OSError:  # a pipe, or the kernel does not support the request
            return bytes(size)
        return bytes(answer)


def joysticks() -> Iterator[tuple[str, str]]:
    """Return the path and name of each joystick that can be opened, in the order of their paths."""
    for path in sorted(glob.glob(DEVICES), key=lambda path: (len(path), path)):
        try:
            with closing(Device(path)) as device:
                yield path, device.name
        except OSError:
            continue
