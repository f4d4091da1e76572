"""Result of an import."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class ImportResult:
    """Result of an import.

    Attributes:
        messages: number of messages written.
        topics: number of topics imported.
        skipped: topic that cannot be represented in ROS 1 -> the reason.
    """

    messages: int = 0
    topics: int = 0
    skipped: dict[str, str] = field(default_factory=dict)
