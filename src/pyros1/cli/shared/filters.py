"""Filter expressions, for ``--filter`` and ``bag filter``, and the names they can use in addition to the message."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

from pyros1.ground.terminal_text import lines
from pyros1.ground.timing import Time
from pyros1.observe.expression import Expression
from pyros1.observe.expression_modules import Module, time_module

if TYPE_CHECKING:
    from pyros1.node import Node


class ExpressionClock:
    """The clock for ``rospy.Time.now()`` in expressions.

    Attributes:
        node: the node whose time is used; None for the system's time.
    """

    node: Node | None = None

    def now(self) -> Time:
        """Return the current time."""
        return Time.from_sec(time.time()) if self.node is None else self.node.now()


def filter_expression(text: str, clock: ExpressionClock | None = None) -> Expression:
    """Parse a filter expression. In addition to the message, it can use print and the times of rospy, genpy and time.

    Args:
        text: the expression.
        clock: the clock for ``rospy.Time.now()``; None for the system's time.

    Raises:
        ExpressionError: the expression is malformed or uses something that is not allowed.
    """
    clock = clock or ExpressionClock()
    extra_names = {
        "print": _print,
        "rospy": time_module(clock.now),
        "genpy": time_module(clock.now, "genpy"),
        "time": Module("time", {"time": time.time}),
    }
    return Expression(text, extra_names)


def _print(*values: Any, sep: str = " ", end: str = "\n") -> None:
    sys.stdout.write(lines(sep.join(map(str, values)) + end))
