"""What became of an import."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Imported:
    """What was imported.

    Attributes:
        messages: written.
        topics: how many.
        skipped: topic -> why ROS 1 has no place for it.
    """

    messages: int = 0
    topics: int = 0
    skipped: dict[str, str] = field(default_factory=dict)
