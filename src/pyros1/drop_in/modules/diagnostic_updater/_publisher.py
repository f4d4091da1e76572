"""Diagnostics of topics."""

from __future__ import annotations

from typing import Any

from diagnostic_updater._diagnostic_updater import *  # noqa: F403
from diagnostic_updater._diagnostic_updater import CompositeDiagnosticTask, DiagnosticTaskVector
from diagnostic_updater._update_functions import *  # noqa: F403
from diagnostic_updater._update_functions import (
    FrequencyStatus,
    FrequencyStatusParam,
    TimeStampStatus,
    TimeStampStatusParam,
)


class HeaderlessTopicDiagnostic(CompositeDiagnosticTask):
    """Tells how often messages come on a topic.

    Args:
        name: of the topic.
        diag: the Updater to which the task is added.
        freq: how often messages should come.
    """

    def __init__(self, name: str, diag: DiagnosticTaskVector, freq: FrequencyStatusParam) -> None:
        super().__init__(f"{name} topic status")
        self.diag = diag
        self.freq = FrequencyStatus(freq)
        self.addTask(self.freq)
        self.diag.add(self)

    def tick(self) -> None:
        """Count a message."""
        self.freq.tick()

    def clear_window(self) -> None:
        """Begin to count anew."""
        self.freq.clear()


class TopicDiagnostic(HeaderlessTopicDiagnostic):
    """Tells how often messages come on a topic, and whether their time stamps are right.

    Args:
        name, diag, freq: as for `HeaderlessTopicDiagnostic`.
        stamp: how old messages may be.
    """

    def __init__(
        self, name: str, diag: DiagnosticTaskVector, freq: FrequencyStatusParam, stamp: TimeStampStatusParam
    ) -> None:
        super().__init__(name, diag, freq)
        self.stamp = TimeStampStatus(stamp)
        self.addTask(self.stamp)

    def tick(self, stamp: Any) -> None:  # type: ignore[override]
        """Count a message with this stamp."""
        self.stamp.tick(stamp)
        super().tick()


class DiagnosedPublisher(TopicDiagnostic):
    """A publisher whose messages count.

    Args:
        pub: the publisher.
        diag, freq, stamp: as for `TopicDiagnostic`.
    """

    def __init__(
        self, pub: Any, diag: DiagnosticTaskVector, freq: FrequencyStatusParam, stamp: TimeStampStatusParam
    ) -> None:
        super().__init__(pub.name, diag, freq, stamp)
        self.publisher = pub

    def publish(self, message: Any) -> None:
        """Publish a message with a header, and count it."""
        self.tick(message.header.stamp)
        self.publisher.publish(message)
