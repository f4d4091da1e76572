"""Connections to boards: serial ports and TCP."""

from __future__ import annotations

import socket
from contextlib import suppress
from errno import EACCES, EAGAIN, EIO, ENOENT, EPERM
from importlib import import_module
from typing import Any, Protocol

from pyros1.ground.errors import Error

READ_TIMEOUT = 0.25
"""Maximum number of seconds that `read` waits."""
WRITE_TIMEOUT = 1.0
_CHUNK = 4096


class PortError(Error):
    """A connection cannot be opened, or is broken."""


class Port(Protocol):
    """A connection to a board."""

    def read(self) -> bytes:
        """Return the received bytes; empty if none arrive within `READ_TIMEOUT`.

        Raises:
            PortError: the connection is broken.
        """

    def write(self, data: bytes) -> None:
        """Send bytes.

        Raises:
            PortError: the connection is broken, or accepts no bytes for `WRITE_TIMEOUT`.
        """

    def close(self) -> None:
        """Close the connection."""


class SerialPort:
    """A serial port, opened with pyserial.

    Args:
        name: the device, such as "/dev/ttyUSB0", or a pyserial URL.
        baud: the speed in bits per second.

    Raises:
        PortError: the port cannot be opened, or pyserial is not installed.
    """

    def __init__(self, name: str, baud: int) -> None:
        try:
            serial: Any = import_module("serial")  # an optional dependency
        except ImportError:
            raise PortError("serial lines need pyserial: pip install 'pyros1[serial]'") from None
        self._name = name
        try:
            self._serial: Any = serial.serial_for_url(
                name, baud, timeout=READ_TIMEOUT, write_timeout=WRITE_TIMEOUT, exclusive=True
            )
        except (OSError, ValueError) as error:
            raise PortError(_explain(name, error)) from None

    def read(self) -> bytes:
        """Return what has arrived; see `Port`."""
        try:
            data: bytes = self._serial.read(max(1, min(self._serial.in_waiting, _CHUNK)))
        except (OSError, TypeError) as error:  # pyserial raises TypeError if the port is closed meanwhile
            raise PortError(_explain(self._name, error)) from None
        return data

    def write(self, data: bytes) -> None:
        """Send bytes; see `Port`."""
        try:
            self._serial.write(data)
        except (OSError, TypeError) as error:
            raise PortError(_explain(self._name, error)) from None

    def close(self) -> None:
        """Close the port."""
        self._serial.close()


def _explain(name: str, error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == ENOENT:
        return f"there is no {name}: plug the board in, or set ~port to its device"
    if number in (EACCES, EPERM):
        return f"no permission to open {name}: sudo usermod -a -G dialout $USER, and log in again"
    if "Could not configure" in str(error):
        return f"{name} is not a serial line"
    if number == EAGAIN:
        return f"{name} is in use by another program"
    if "returned no data" in str(error) or number == EIO:
        return f"{name} was unplugged, or another program reads from it"
    return f"{name}: {error}"


class TcpPort:
    """A TCP connection from a board.

    Args:
        sock: the connected socket.
        name: the board's address, for errors.
    """

    def __init__(self, sock: socket.socket, name: str) -> None:
        self._socket, self._name = sock, name
        self._end = "has closed the connection"
        sock.settimeout(READ_TIMEOUT)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def read(self) -> bytes:
        """Return what has arrived; see `Port`."""
        try:
            data = self._socket.recv(_CHUNK)
        except TimeoutError:
            return b""
        except OSError as error:
            raise PortError(f"{self._name}: {error.strerror}") from None
        if not data:
            raise PortError(f"{self._name} {self._end}")
        return data

    def write(self, data: bytes) -> None:
        """Send bytes; see `Port`."""
        try:
            self._socket.sendall(data)
        except OSError as error:
            # Part of the frame may have been sent, and a board that accepts no data is not running. The socket is not
            # closed here: the reading thread could then read from a new socket with the same file descriptor.
            self._end = "took no data"
            with suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)
            raise PortError(f"{self._name}: {error.strerror or 'takes no data'}") from None

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()
