"""Handles unusual standard streams.

A stream can be closed or have an encoding other than UTF-8. Writing to stdout can fail because a disk is full, or
because the program at the other end of a pipe has exited.
"""

from __future__ import annotations

import codecs
import io
import os
import sys
import warnings
from typing import Any, TextIO

_ASCII_REPLACEMENTS = str.maketrans(
    {"─": "-", "│": "|", "├": "|", "└": "`", "•": "*", "…": "...", "→": "->", "←": "<-", "↔": "<->", "·": "."}
)
"""ASCII replacements for drawing characters that the encoding lacks."""
_ERROR_HANDLER = "pyros1"
"""The name under which the handler for encoding errors is registered."""
STDOUT_NAME = "standard output"
"""The name of standard output in error messages."""


def prepare_streams() -> None:
    """Prepare the standard streams and warnings at the start of a command's process.

    Closed streams are connected to the null device. Errors in writing to stdout are given the file name `STDOUT_NAME`.
    Characters that an encoding lacks are replaced instead of raising errors.
    """
    if sys.stdin is None or sys.stdout is None or sys.stderr is None:
        _open_closed_streams()
    sys.stdout = _with_named_errors(sys.stdout)
    warnings.formatwarning = _format_warning
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and not stream.encoding.lower().startswith("utf"):
            codecs.register_error(_ERROR_HANDLER, _replace_character)
            stream.reconfigure(errors=_ERROR_HANDLER)
        elif isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")  # file names may contain undecodable bytes


def _format_warning(
    message: Warning | str, category: object, filename: str, lineno: int, line: str | None = None
) -> str:
    """Format a warning without its location in the source code of pyros1."""
    return f"WARNING: {message}\n"


def _open_closed_streams() -> None:
    """Connect closed standard streams to the null device.

    Otherwise, a file or socket that is opened later could get the descriptor of a standard stream, and child processes
    would read from it or write to it.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(descriptor, True)
    os.close(descriptor)
    sys.stdin = sys.stdin or open(0, closefd=False)  # noqa: SIM115 - open until the process exits
    sys.stdout = sys.stdout or open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = sys.stderr or open(2, "w", closefd=False)  # noqa: SIM115


def _replace_character(error: UnicodeError) -> tuple[str | bytes, int]:
    """Return a replacement for a character that the encoding lacks.

    Undecodable bytes of file names, which Python represents as surrogates, are returned as bytes.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    character = error.object[error.start]
    if "\udc80" <= character <= "\udcff":
        return bytes([ord(character) - 0xDC00]), error.start + 1
    replacement = character.translate(_ASCII_REPLACEMENTS)
    if replacement == character:
        replacement = character.encode("ascii", "backslashreplace").decode("ascii")
    return replacement, error.start + 1


class _NamedOutput(io.FileIO):
    """A file for standard output. Errors in writing have the file name `STDOUT_NAME`; Python itself gives no name."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError as error:
            error.filename = STDOUT_NAME
            raise


def _with_named_errors(stream: TextIO) -> TextIO:
    """Return an equivalent stream whose errors have the file name `STDOUT_NAME`."""
    if not isinstance(stream, io.TextIOWrapper):
        return stream
    raw_stream = _NamedOutput(stream.fileno(), "w", closefd=False)
    return io.TextIOWrapper(
        raw_stream if isinstance(stream.buffer, io.RawIOBase) else io.BufferedWriter(raw_stream),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )


def discard_output() -> None:
    """Connect stdout to the null device, so that flushing it when the interpreter exits cannot fail again."""
    null_device = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null_device, sys.stdout.fileno())
    os.close(null_device)
