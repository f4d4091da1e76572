"""One thing that is wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

ERROR, WARNING = "error", "warning"


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong, or may be, and what to do about it.

    Attributes:
        kind: short name for programs, for example ``dead-node``.
        severity: ``error`` or ``warning``: what may be just as it should be.
        text: what is wrong, in one sentence.
        cure: what to do, in one line.
        items: what it is about: nodes, topics, folders.
    """

    kind: str
    severity: str
    text: str
    cure: str
    items: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """The same for programs."""
        return {
            "kind": self.kind,
            "severity": self.severity,
            "text": self.text,
            "items": list(self.items),
            "cure": self.cure,
        }
