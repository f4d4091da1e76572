"""What the table is made of: rows, their goals, and the steps that are run for their figures."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from conditions import QUIET

if TYPE_CHECKING:
    from steps import Bench

OURS, ROSCPP, ROSPY = "ours", "roscpp", "rospy"
COLUMNS = (OURS, ROSCPP, ROSPY)
FACE = "face"
"""pyros1 under the name of rospy."""


class Step(Protocol):
    """Something that is run once per turn. Equal steps are the same: rows share their figures."""

    def __hash__(self) -> int: ...

    @property
    def label(self) -> str:
        """What is shown while it runs."""

    def run(self, bench: Bench) -> dict[str, float]:
        """Run it and return its figures by name."""


Results = dict[Step, list["dict[str, float] | None"]]
"""The figures of every turn; None for a turn that failed."""
ResultsByCondition = Mapping[str, Results]
"""Results under each condition, see `conditions`; the first one is the quiet machine, if that was measured."""


@dataclass(frozen=True)
class Goal:
    """A bound: how many times better than another column we have to be, or what our figure itself may be.

    Attributes:
        bound: the limit.
        than: the other column; None: the bound is for our figure.
        called: what the other column holds here, if it is not what its name says.
        most: the figure must not be above the bound (not below, otherwise).
    """

    bound: float
    than: str | None = None
    called: str = ""
    most: bool = False

    def text(self, unit: str) -> str:
        """The goal in words."""
        return f"{'<=' if self.most else '>='} {self.bound:g} {f'x {self.called or self.than}' if self.than else unit}"


def at_least(roscpp: float | None = None, rospy: float | None = None) -> tuple[Goal, ...]:
    """So many times better than roscpp and rospy."""
    bounds = {ROSCPP: roscpp, ROSPY: rospy}
    return tuple(Goal(bound, column) for column, bound in bounds.items() if bound is not None)


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes:
        group: what it belongs to.
        name: what is measured.
        unit: of the figures.
        figure: name of the figure in what the steps return.
        steps: what is run for each column; a column that is missing has no figure.
        goals: what is wanted.
        less: smaller figures are better.
    """

    group: str
    name: str
    unit: str
    figure: str
    steps: Mapping[str, Step]
    goals: tuple[Goal, ...] = ()
    less: bool = False

    def values(self, results: Results, column: str) -> list[float]:
        """The figures of a column, one for each turn that succeeded."""
        runs = results.get(self.steps[column], []) if column in self.steps else []
        figures = [run[self.figure] for run in runs if run and self.figure in run]
        return [figure for figure in figures if not math.isnan(figure)]

    def median(self, results: Results, column: str) -> float | None:
        """The median of a column; None if it has no figure."""
        values = self.values(results, column)
        return statistics.median(values) if values else None

    def ratio(self, results: Results, column: str) -> float | None:
        """How many times better than a column we are; None if one of the two has no figure, or one below 0."""
        ours, other = self.median(results, OURS), self.median(results, column)
        if ours is None or other is None or min(ours, other) < 0:
            return None
        worse, better = (ours, other) if self.less else (other, ours)
        return better / worse if worse else math.inf

    def ratios(self, results: Results, column: str) -> list[float]:
        """How many times better than a column we were, by turn, without turns in which one of the two failed."""
        both = zip(results.get(self.steps[OURS], ()), results.get(self.steps[column], ()), strict=False)
        pairs = [(ours.get(self.figure, -1.0), other.get(self.figure, -1.0)) for ours, other in both if ours and other]
        ordered = [(other, ours) if self.less else (ours, other) for ours, other in pairs]
        return [above / below for above, below in ordered if above > 0 and below > 0]

    def met(self, results: Results, goal: Goal) -> bool:
        """Whether a goal is reached; it is not if a figure is missing, or if we failed in any turn."""
        if self.failures(results, OURS):
            return False
        value = self.ratio(results, goal.than) if goal.than else self.median(results, OURS)
        if value is None:
            return False
        return value <= goal.bound if goal.most else value >= goal.bound

    def goals_under(self, condition: str) -> tuple[Goal, ...]:
        """The goals that hold under a condition: ratios always, bounds for our own figure on a quiet machine only."""
        return tuple(goal for goal in self.goals if condition == QUIET or goal.than)

    def lost(self, measured: ResultsByCondition, condition: str) -> list[str]:
        """The columns than which we are better on a quiet machine, but worse under a condition."""
        if QUIET not in measured:
            return []
        ratios = {
            column: (self.ratio(measured[QUIET], column), self.ratio(measured[condition], column))
            for column in self.steps
            if column != OURS
        }
        return [
            column
            for column, (quiet, other) in ratios.items()
            if quiet is not None and other is not None and quiet >= 1 > other
        ]

    def failures(self, results: Results, column: str) -> int:
        """In how many turns a column has no figure although it should have one."""
        runs = results.get(self.steps[column], []) if column in self.steps else []
        return len(runs) - len(self.values(results, column))


def distinct_steps(rows: list[Row]) -> list[Step]:
    """The steps of the rows, each once, in the rows' order: the columns take turns."""
    return list(dict.fromkeys(step for row in rows for step in row.steps.values()))
