"""Standard output in all its states: closed, full, a pipe without reader, or an encoding that lacks characters."""

from __future__ import annotations

import codecs
import io
import os
import sys
import warnings
from typing import Any, TextIO

_STAND_INS = str.maketrans(
    {"─": "-", "│": "|", "├": "|", "└": "`", "•": "*", "…": "...", "→": "->", "←": "<-", "↔": "<->", "·": "."}
)
"""ASCII replacements of drawing characters that the encoding lacks."""
_HANDLER = "pyros1"
NAME = "standard output"
"""The name of standard output in errors."""


def prepare() -> None:
    """Make standard output and error usable at the start of a command's process."""
    if sys.stdin is None or sys.stdout is None or sys.stderr is None:
        _fill_descriptors()
    sys.stdout = _named(sys.stdout)
    warnings.formatwarning = _warning
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and not stream.encoding.lower().startswith("utf"):
            codecs.register_error(_HANDLER, _replace)
            stream.reconfigure(errors=_HANDLER)
        elif isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")  # undecodable bytes of file names


def _warning(message: Warning | str, category: object, filename: str, lineno: int, line: str | None = None) -> str:
    """Return the text of a warning, without its location in pyros1's source."""
    return f"WARNING: {message}\n"


def _fill_descriptors() -> None:
    """Open streams that the caller has closed: otherwise a child's standard output would be the next socket."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(descriptor, True)
    os.close(descriptor)
    sys.stdin = sys.stdin or open(0, closefd=False)  # noqa: SIM115 - open until the process ends
    sys.stdout = sys.stdout or open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = sys.stderr or open(2, "w", closefd=False)  # noqa: SIM115


def _replace(error: UnicodeError) -> tuple[str | bytes, int]:
    """Encode a character that the encoding lacks: undecodable bytes of file names unchanged, others similarly."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    character = error.object[error.start]
    if "\udc80" <= character <= "\udcff":
        return bytes([ord(character) - 0xDC00]), error.start + 1
    stand_in = character.translate(_STAND_INS)
    if stand_in == character:
        stand_in = character.encode("ascii", "backslashreplace").decode("ascii")
    return stand_in, error.start + 1


class _Descriptor(io.FileIO):
    """A file whose errors have its name, unlike errors of print."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError as error:
            error.filename = NAME
            raise


def _named(stream: TextIO) -> TextIO:
    """Return an equivalent stream whose errors have `NAME` as file name."""
    if not isinstance(stream, io.TextIOWrapper):
        return stream
    raw = _Descriptor(stream.fileno(), "w", closefd=False)
    return io.TextIOWrapper(
        raw if isinstance(stream.buffer, io.RawIOBase) else io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )


def abandon() -> None:
    """Discard what could not be written, so that the interpreter ends silently."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, sys.stdout.fileno())
    os.close(null)
