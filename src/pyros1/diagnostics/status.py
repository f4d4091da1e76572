"""The status of one part of a node or of its hardware, which a task fills in."""

from __future__ import annotations

from typing import Any

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticStatus, KeyValue

OK, WARN, ERROR, STALE = 0, 1, 2, 3


class Status(DiagnosticStatus):
    """A diagnostic_msgs/DiagnosticStatus with methods that fill it in."""

    def summary(self, level: int, message: str) -> None:
        """Set the level (OK, WARN, ERROR or STALE) and the message."""
        self.level, self.message = level, message

    def merge(self, level: int, message: str) -> None:
        """Merge a level and a message into the current ones.

        The worse level is kept. If only one of the two levels is a problem, its message is kept; otherwise, the
        messages are joined.
        """
        if (level > OK) != (self.level > OK):
            if level > self.level:
                self.message = message
        elif self.message:
            self.message = f"{self.message}; {message}"
        else:
            self.message = message
        self.level = max(self.level, level)

    def add(self, key: str, value: Any) -> None:
        """Add a value under a name. The value is converted with ``str``."""
        self.values.append(KeyValue(key, str(value)))
