"""Converts parameters to the form in which they are sent to boards: arrays of one type."""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import Error
from pyros1.msgs.rosserial_msgs.srv import RequestParam


class UnsuitableParameterError(Error):
    """A parameter cannot be sent to a board."""


def parameter_response(name: str, value: Any) -> Any:
    """Return a RequestParamResponse with a parameter's value.

    Args:
        name: the parameter's name, for the errors.
        value: a bool, an integer, a number, a string, or a list of one of these; None if it is not set.

    Raises:
        UnsuitableParameterError: the parameter is not set, or values of its type cannot be sent to boards.
    """
    if value is None:
        raise UnsuitableParameterError(f"the board asks for the parameter {name}, which is not set")
    values = value if isinstance(value, list) else [value]
    fields = {_field_of(element) for element in values}
    field = fields.pop() if len(fields) == 1 else "ints" if not fields else ""
    if not field:
        raise UnsuitableParameterError(
            f"the board asks for the parameter {name}, which it cannot get: it must be a number, a string, "
            "or a list of integers, of other numbers or of strings"
        )
    response = RequestParam._response_class()
    setattr(response, field, [int(element) if field == "ints" else element for element in values])
    return response


def _field_of(value: Any) -> str:
    if isinstance(value, int):  # bools, too
        return "ints" if -(2**31) <= value < 2**31 else ""
    return "floats" if isinstance(value, float) else "strings" if isinstance(value, str) else ""
