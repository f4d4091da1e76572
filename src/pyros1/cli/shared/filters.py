"""The expressions of ``--filter`` and ``bag filter``, and the names that they can use in addition to the message."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

from pyros1.ground.terminal_text import lines
from pyros1.ground.timing import Time
from pyros1.observe.expression import Expression
from pyros1.observe.modules import Module, time_module

if TYPE_CHECKING:
    from pyros1.node import Node


class Clock:
    """The clock for ``rospy.Time.now()`` in expressions.

    Attributes:
        node: the node whose time is used; None for the system's time.
    """

    node: Node | None = None

    def now(self) -> Time:
        """Return the time."""
        return Time.from_sec(time.time()) if self.node is None else self.node.now()


def filter_expression(text: str, clock: Clock | None = None) -> Expression:
    """Return the expression of a filter, which can also use print, and the times of rospy and genpy.

    Args:
        text: the expression.
        clock: the clock; None for the system's time.

    Raises:
        ExpressionError: the expression is malformed or uses something that is not allowed.
    """
    clock = clock or Clock()
    names = {
        "print": _print,
        "rospy": time_module(clock.now),
        "genpy": time_module(clock.now, "genpy"),
        "time": Module("time", {"time": time.time}),
    }
    return Expression(text, names)


def _print(*values: Any, sep: str = " ", end: str = "\n") -> None:
    sys.stdout.write(lines(sep.join(map(str, values)) + end))
