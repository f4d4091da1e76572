"""Computes another joystick's axes and buttons from this one's with expressions (no I/O).

An expression is a number, or text such as ``max(axes[10], 0.0) * -1.0`` or ``buttons[3]``, in a safe subset of Python.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite

from pyros1.ground.errors import Error
from pyros1.observe.expression import Expression, ExpressionError

MAX_EXPRESSIONS = 256
"""Maximum number of axes, and of buttons."""


class Remapping:
    """The expressions for a joystick.

    Args:
        axes: the expressions for the axes.
        buttons: the expressions for the buttons. A button is pressed if the value is above 0.
        report: called with a one-line message whenever the value of an expression cannot be used.

    Raises:
        Error: an expression is malformed, or there are too many.
    """

    def __init__(self, axes: object, buttons: object, report: Callable[[str], object]) -> None:
        self._axes = _read(axes, "axes")
        self._buttons = _read(buttons, "buttons")
        self._report = report

    def __call__(self, axes: Sequence[float], buttons: Sequence[int]) -> tuple[list[float], list[int]]:
        """Convert axes and buttons; the result is 0 where the value of an expression cannot be used."""
        values: dict[str, Sequence[float]] = {"axes": list(axes), "buttons": list(buttons)}
        return (
            [self._evaluate(expression, values) for expression in self._axes],
            [int(self._evaluate(expression, values) > 0) for expression in self._buttons],
        )

    def _evaluate(self, expression: Expression, values: dict[str, Sequence[float]]) -> float:
        try:
            value = expression(values)
        except ExpressionError as error:
            self._report(f"{error}: the joystick has {len(values['axes'])} axes and {len(values['buttons'])} buttons")
            return 0.0
        if isinstance(value, (int, float)) and abs(value) < _LARGEST_FLOAT32 and isfinite(value):
            return float(value)
        self._report(f"[{expression.text}] is not a number that an axis can have")
        return 0.0


_LARGEST_FLOAT32 = 3.4e38


def _read(values: object, kind: str) -> list[Expression]:
    if not isinstance(values, (list, tuple)):
        raise Error(
            f"~mappings/{kind} must be a list of expressions such as axes[0] or buttons[3], not {values!r:.100}"
        )
    if len(values) > MAX_EXPRESSIONS:
        raise Error(f"~mappings/{kind} has {len(values)} expressions, but {MAX_EXPRESSIONS} are the most")
    try:
        expressions = [Expression(str(value)) for value in values]
    except ExpressionError as error:
        raise Error(f"~mappings/{kind}: {error}") from error
    return expressions
