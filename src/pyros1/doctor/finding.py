"""A finding: a problem and how to fix it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

ERROR, WARNING = "error", "warning"


@dataclass(frozen=True)
class Finding:
    """A problem or possible problem, and what to do about it.

    Attributes:
        kind: short name for programs, for example ``dead-node``.
        severity: ``error``, or ``warning`` for what may be intended.
        text: what is wrong, in one sentence.
        cure: what to do, in one line.
        items: the nodes, topics or folders concerned.
    """

    kind: str
    severity: str
    text: str
    cure: str
    items: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return the finding as a dictionary for JSON."""
        return {
            "kind": self.kind,
            "severity": self.severity,
            "text": self.text,
            "items": list(self.items),
            "cure": self.cure,
        }
