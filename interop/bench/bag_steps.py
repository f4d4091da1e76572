"""How the figures of bags are measured: bags.py, one work at a time."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from harness import STOCK_PYTHON
from model import OURS

if TYPE_CHECKING:
    from steps import Bench

SCRIPT = Path(__file__).resolve().parent / "bags.py"


@dataclass(frozen=True)
class BagWork:
    """One work of bags.py.

    Attributes:
        side: ``ours``, ``stock`` or ``rosbags``.
        work: its name there.
        python: the interpreter; rosbags needs this one, which has it.
    """

    side: str
    work: str
    python: str = STOCK_PYTHON

    @property
    def label(self) -> str:
        return f"bags.py {self.side}: {self.work}"

    def run(self, bench: Bench) -> dict[str, float]:
        words = ("--side", self.side, "--work", self.work, "--seconds", str(2 * bench.seconds))
        out = bench.output(self.python, str(SCRIPT), *words, kind=OURS)
        return {name: float(value) for name, value in json.loads(out.splitlines()[-1]).items()}
