"""Copes with unusual standard streams: closed, on a full disk, without a reader, or in an encoding other than UTF-8."""

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
    """Make the standard streams usable at the start of a command's process."""
    if sys.stdin is None or sys.stdout is None or sys.stderr is None:
        _open_closed_streams()
    sys.stdout = _with_named_errors(sys.stdout)
    warnings.formatwarning = _format_warning
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and not stream.encoding.lower().startswith("utf"):
            codecs.register_error(_ERROR_HANDLER, _replace_character)
            stream.reconfigure(errors=_ERROR_HANDLER)
        elif isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")  # for undecodable bytes in file names


def _format_warning(
    message: Warning | str, category: object, filename: str, lineno: int, line: str | None = None
) -> str:
    """Format a warning without its location in the source code of pyros1."""
    return f"WARNING: {message}\n"


def _open_closed_streams() -> None:
    """Open the standard streams that are closed. Otherwise, child processes could use a socket as a standard stream."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(descriptor, True)
    os.close(descriptor)
    sys.stdin = sys.stdin or open(0, closefd=False)  # noqa: SIM115 - open until the process exits
    sys.stdout = sys.stdout or open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = sys.stderr or open(2, "w", closefd=False)  # noqa: SIM115


def _replace_character(error: UnicodeError) -> tuple[str | bytes, int]:
    """Encode a character that the encoding lacks. Only undecodable bytes of file names are kept as they are."""
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
    """A file that adds its name to the errors that writing raises, which Python does not do for standard output."""

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
    """Discard output that could not be written, so that the interpreter exits silently."""
    null_device = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null_device, sys.stdout.fileno())
    os.close(null_device)
