"""The status that tasks fill."""

from __future__ import annotations

from typing import Any

from pyros1.diagnostics.status import Status
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticStatus, KeyValue

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR

__all__ = ["ERROR", "OK", "WARN", "DiagnosticStatus", "DiagnosticStatusWrapper", "KeyValue"]


def _given(args: tuple[Any, ...]) -> tuple[int, str]:
    """Return level and message, given as these two, or as a status."""
    if len(args) == 1:
        return args[0].level, args[0].message
    level, message = args
    return level, str(message)


class DiagnosticStatusWrapper(Status):
    """A DiagnosticStatus with what tasks need to fill it."""

    def summary(self, *args: Any) -> None:
        """Set the summary: a level and a message, or those of another status."""
        Status.summary(self, *_given(args))

    def clearSummary(self) -> None:
        """Set the level OK and no message."""
        self.summary(OK, "")

    def mergeSummary(self, *args: Any) -> None:
        """Merge the summary with a level and a message, or with those of another status; see `Status.merge`."""
        self.merge(*_given(args))
