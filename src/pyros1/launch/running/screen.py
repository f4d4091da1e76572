"""Writes the output of nodes to the screen, with the node's name before each line.

If the launcher writes to a terminal, the nodes use a pseudo terminal, so that they write line by line and in colour, as
if they were run directly. The output is read to its end, including a last line without a line break.
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from typing import TextIO

from pyros1.launch.running.process_spec import ProcessSpec

_CHUNK_SIZE = 65536
_COLOURS = (36, 33, 35, 32, 34, 96, 93, 95, 92, 94)


class Screen:
    """Writes the output of nodes in whole lines.

    Args:
        out: stream for their standard output.
        err: stream for their standard error.
        colour: whether to colour names; None to colour them only on terminals.
    """

    def __init__(self, out: TextIO, err: TextIO, *, colour: bool | None = None) -> None:
        self._streams = (out, err)
        self._colour = colour
        self._lock = threading.Lock()
        self._readers: list[threading.Thread] = []

    @contextlib.contextmanager
    def open_outputs(self, spec: ProcessSpec) -> Iterator[tuple[int, int]]:
        """Yield file descriptors for a node's standard output and error, and close them afterwards.

        Reading starts at the end of the ``with`` block, so anything written to the screen in the block precedes the
        node's output.
        """
        pipes, readers = [], []
        for stream in self._streams:
            read_end, write_end = os.openpty() if stream.isatty() and hasattr(os, "openpty") else os.pipe()
            pipes.append(write_end)
            arguments = (read_end, stream, self.line_prefix(spec.node, stream))
            # A daemon, since children of an exited node may keep its output open forever.
            readers.append(
                threading.Thread(target=self._read, args=arguments, name=f"screen {spec.label}", daemon=True)
            )
        try:
            yield pipes[0], pipes[1]
        finally:
            for descriptor in pipes:
                os.close(descriptor)
            for reader in readers:
                reader.start()
            self._readers += readers

    def line_prefix(self, node: str, stream: TextIO) -> bytes:
        """Return the prefix of a node's lines. A node has the same colour in each run."""
        text = f"[{node.lstrip('/')}] "
        if self._colour if self._colour is not None else stream.isatty():
            text = f"\033[{_COLOURS[sum(node.encode()) % len(_COLOURS)]}m{text}\033[0m"
        return text.encode()

    def _read(self, read_end: int, stream: TextIO, line_prefix: bytes) -> None:
        partial_line = b""
        while True:
            try:
                data = os.read(read_end, _CHUNK_SIZE)
            except OSError:  # raised by a pseudo terminal whose other end is closed
                data = b""
            *lines, partial_line = (partial_line + data).replace(b"\r\n", b"\n").split(b"\n")
            if not data and partial_line:
                lines, partial_line = [partial_line], b""
            if lines:
                self._write(stream, b"".join(line_prefix + line + b"\n" for line in lines))
            if not data:
                os.close(read_end)
                return

    def write(self, node: str, stream: TextIO, text: str) -> None:
        """Write whole lines of output from a node on another machine.

        Args:
            node: the node's name.
            stream: the stream to write to.
            text: one or more lines.
        """
        line_prefix = self.line_prefix(node, stream)
        self._write(stream, b"".join(line_prefix + line + b"\n" for line in text.encode().splitlines()))

    def _write(self, stream: TextIO, data: bytes) -> None:
        with self._lock, contextlib.suppress(BrokenPipeError, ValueError):
            stream.write(data.decode("utf-8", "replace"))
            stream.flush()

    def close(self, timeout: float = 1.0) -> None:
        """Wait until the output of exited nodes has been written.

        Args:
            timeout: maximum number of seconds to wait for each node.
        """
        for reader in self._readers:
            reader.join(timeout)
        self._readers.clear()
