"""Logs an error, as stock does, if a message contains strings that are not UTF-8."""

from __future__ import annotations

import codecs

_REPORTED_TYPES: set[str | None] = set()
_MAX_REPORTED = 1000
"""Maximum number of types to remember, since a program that echoes topics can receive any number of types."""


class RosMsgUnicodeErrors:
    """Handler ``rosmsg`` for `codecs.register_error`: replaces bytes that are not UTF-8; logs an error once per type.

    Attributes:
        msg_type: the type of the message, for the log.
    """

    def __init__(self) -> None:
        self.msg_type: str | None = None

    def __call__(self, err: UnicodeError) -> tuple[str | bytes, int]:
        if self.msg_type not in _REPORTED_TYPES and len(_REPORTED_TYPES) < _MAX_REPORTED:
            _REPORTED_TYPES.add(self.msg_type)
            type_text = "unknown message" if self.msg_type is None else f"message {self.msg_type}"
            import logging  # noqa: PLC0415  rarely needed, and some programs do not import logging

            log = logging.getLogger("rosout")
            log.error("Characters replaced when decoding %s (will print only once): %s", type_text, err)
        return codecs.replace_errors(err)


def register() -> None:
    """Register the handler in this process."""
    codecs.register_error("rosmsg", RosMsgUnicodeErrors())
