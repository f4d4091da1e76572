"""Parses the head of an HTTP message: its first line and its fields (RFC 9112, 5)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from pyros1.ground.errors import ProtocolError

# strftime would use names in the user's language.
_DAYS: Final = ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun")
_MONTHS: Final = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_FIELD_LINE: Final = re.compile(r"^([!#-'*+.^_`|~\w-]+):(.*)$", re.ASCII | re.MULTILINE)


class HttpError(ProtocolError):
    """The peer violated HTTP, or exceeded a limit.

    Args:
        message: what is wrong.
        status: the status code with which a server responds.
    """

    def __init__(self, message: str, status: int = 400) -> None:
        self.status = status
        super().__init__(message)


def split_head(text: str) -> tuple[str, dict[str, str], bool]:
    """Return the first line of a head, its fields by lower-case name, and whether there is at most one Content-Length.

    Raises:
        HttpError: a line is not a field, or two Content-Length fields differ.
    """
    first_line, _, rest = text.partition("\n")
    # A bare CR counts as a space (RFC 9112, 2.2).
    fields = [(name.lower(), value.strip(" \t\r")) for name, value in _FIELD_LINE.findall(rest)]
    if rest and len(fields) != rest.count("\n") + 1:
        invalid_line = next(line for line in rest.split("\n") if not _FIELD_LINE.match(line))
        raise HttpError("not an HTTP header field: " + repr(invalid_line[:40]))
    headers = dict(fields)
    lengths = [value for name, value in fields if name == "content-length"] if len(headers) != len(fields) else []
    if any(length != lengths[0] for length in lengths):
        raise HttpError("two different Content-Length fields")
    return first_line.rstrip("\r"), headers, len(lengths) < 2


def stays_open(minor_version: str, headers: dict[str, str]) -> bool:
    """Return whether the connection stays open after a message of HTTP version 1.``minor_version``."""
    connection = headers.get("connection", "").lower()
    if minor_version == "1":
        return "close" not in connection
    return "keep-alive" in connection


def date_field(when: Sequence[int]) -> bytes:
    """Return the Date field of a head as a line (RFC 9110, 5.6.7 and 6.6.1).

    Args:
        when: year, month, day, hour, minute, second and weekday in UTC, as returned by `time.gmtime`.
    """
    year, month, day, hour, minute, second, weekday, *_ = when
    date = f"{_DAYS[weekday]}, {day:02} {_MONTHS[month - 1]} {year:04} {hour:02}:{minute:02}:{second:02} GMT"
    return f"Date: {date}\r\n".encode()
