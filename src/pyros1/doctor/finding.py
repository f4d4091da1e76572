"""Findings: problems and how to fix them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

ERROR, WARNING = "error", "warning"


@dataclass(frozen=True)
class Finding:
    """A problem or possible problem, and how to fix it.

    Attributes:
        kind: a short name for programs, such as ``dead-node``.
        severity: ``error``, or ``warning`` if the situation may be intended.
        text: a one-sentence description of the problem.
        fix: a one-line description of the fix.
        items: the affected nodes, topics or folders.
    """

    kind: str
    severity: str
    text: str
    fix: str
    items: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return the finding as a JSON object."""
        return {
            "kind": self.kind,
            "severity": self.severity,
            "text": self.text,
            "items": list(self.items),
            "cure": self.fix,
        }
