"""Tasks that monitor a topic."""

from __future__ import annotations

from typing import Any

from diagnostic_updater._diagnostic_updater import CompositeDiagnosticTask
from diagnostic_updater._update_functions import FrequencyStatus, TimeStampStatus
from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr("diagnostic_updater._publisher")


class HeaderlessTopicDiagnostic(CompositeDiagnosticTask):
    """Monitors the rate of messages on a topic.

    Args:
        name: the topic's name.
        diag: the `Updater` that runs the task.
        freq: a `FrequencyStatusParam`.
    """

    def __init__(self, name: str, diag: Any, freq: Any) -> None:
        super().__init__(f"{name} topic status")
        self.diag = diag
        self.freq = FrequencyStatus(freq)
        self.addTask(self.freq)
        self.diag.add(self)

    def tick(self) -> None:
        """Count a message."""
        self.freq.tick()

    def clear_window(self) -> None:
        """Restart counting."""
        self.freq.clear()


class TopicDiagnostic(HeaderlessTopicDiagnostic):
    """Monitors the rate of messages on a topic, and their time stamps.

    Args:
        name, diag, freq: see `HeaderlessTopicDiagnostic`.
        stamp: a `TimeStampStatusParam`.
    """

    def __init__(self, name: str, diag: Any, freq: Any, stamp: Any) -> None:
        super().__init__(name, diag, freq)
        self.stamp = TimeStampStatus(stamp)
        self.addTask(self.stamp)

    def tick(self, stamp: Any) -> None:  # type: ignore[override]
        """Count a message with a time stamp, as rospy.Time or in seconds."""
        self.stamp.tick(stamp)
        super().tick()


class DiagnosedPublisher(TopicDiagnostic):
    """A publisher whose messages are monitored.

    Args:
        pub: a rospy.Publisher of messages with a header.
        diag, freq, stamp: see `TopicDiagnostic`.
    """

    def __init__(self, pub: Any, diag: Any, freq: Any, stamp: Any) -> None:
        super().__init__(pub.name, diag, freq, stamp)
        self.publisher = pub

    def publish(self, message: Any) -> None:
        """Publish a message."""
        self.tick(message.header.stamp)
        self.publisher.publish(message)
