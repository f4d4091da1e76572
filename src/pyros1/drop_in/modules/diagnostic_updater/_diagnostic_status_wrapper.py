"""The status message that tasks fill in."""

from __future__ import annotations

from typing import Any

from pyros1.diagnostics import Status
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticStatus, KeyValue

__getattr__ = module_getattr("diagnostic_updater._diagnostic_status_wrapper")

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR


class DiagnosticStatusWrapper(Status):
    """A diagnostic_msgs/DiagnosticStatus with methods to fill it in, and with the same constructor.

    The arguments of `summary` and `mergeSummary` are a level and a message, or another status.
    """

    def __init__(self, *args: Any, **kwds: Any) -> None:
        super().__init__(*args, **kwds)

    def summary(self, *args: Any) -> None:
        """Set level and message."""
        super().summary(*_level_and_message(args))

    def clearSummary(self) -> None:
        """Set the level to OK, and clear the message."""
        super().summary(OK, "")

    def mergeSummary(self, *args: Any) -> None:
        """Merge a level and message: the worse level is used, and the messages of problems are kept."""
        level, message = _level_and_message(args)
        self.merge(level, str(message))

    def add(self, key: Any, val: Any) -> None:
        """Add a named value, converted to a string."""
        super().add(key, val)


def _level_and_message(args: tuple[Any, ...]) -> tuple[Any, Any]:
    if len(args) == 1:
        return args[0].level, args[0].message
    level, message = args
    return level, message
