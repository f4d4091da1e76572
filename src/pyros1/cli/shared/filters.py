"""Expressions of ``--filter`` and ``bag filter``: what they may use besides the message."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

from pyros1.ground.terminal_text import lines
from pyros1.ground.timing import Time
from pyros1.observe.expression import Expression
from pyros1.observe.modules import Module, times

if TYPE_CHECKING:
    from pyros1.node import Node


class Clock:
    """The time for ``rospy.Time.now()``.

    Attributes:
        node: whose time it is; None: the system's.
    """

    node: Node | None = None

    def now(self) -> Time:
        """Return the time."""
        return Time.from_sec(time.time()) if self.node is None else self.node.now()


def filter_expression(text: str, clock: Clock | None = None) -> Expression:
    """Return a filter's expression. Besides what all expressions may use, it has print, and times of rospy and genpy.

    Args:
        text: the expression.
        clock: the time; None: the system's.

    Raises:
        ExpressionError: it is malformed, or uses something that is not allowed.
    """
    clock = clock or Clock()
    more = {
        "print": _print,
        "rospy": times(clock.now),
        "genpy": times(clock.now, "genpy"),
        "time": Module("time", {"time": time.time}),
    }
    return Expression(text, more)


def _print(*values: Any, sep: str = " ", end: str = "\n") -> None:
    sys.stdout.write(lines(sep.join(map(str, values)) + end))
