"""Modules in expressions, which are named sets of values and functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground.expressions import ExpressionError
from pyros1.ground.timing import Duration, Time


class Module:
    """A named set of values, which may be callable (like ``rospy.Time``).

    Args:
        name: the name, for error messages.
        members: the values by name.
        call: the function that implements calls to the module; None if the module is not callable.

    Attributes:
        names: the names of the members.
    """

    def __init__(self, name: str, members: Mapping[str, Any], call: Callable[..., Any] | None = None) -> None:
        self.name = name
        self.names = tuple(members)
        self._members = members
        self._call = call

    def get(self, name: str) -> Any:
        """Return a member.

        Raises:
            ExpressionError: no member has that name.
        """
        if name not in self._members:
            known = ", ".join(sorted(self._members))
            raise ExpressionError(
                f"expressions cannot use {self.name}.{name}; they can use these members of {self.name}: {known}"
            )
        return self._members[name]

    def __call__(self, *args: Any, **keywords: Any) -> Any:
        """Call the module, such as ``rospy.Time``.

        Raises:
            TypeError: the module is not callable.
        """
        if self._call is None:
            raise TypeError(f"{self.name} is a module")
        return self._call(*args, **keywords)


def time_module(now: Callable[[], Time], name: str = "rospy") -> Module:
    """Return a module with the times of rospy or genpy.

    Args:
        now: the implementation of ``rospy.Time.now()`` and similar functions.
        name: ``rospy`` or ``genpy``.
    """
    time_class = Module(f"{name}.Time", {"now": now, "from_sec": Time.from_sec, "from_seconds": Time.from_sec}, Time)
    duration_class = Module(
        f"{name}.Duration", {"from_sec": Duration.from_sec, "from_seconds": Duration.from_sec}, Duration
    )
    members: dict[str, Any] = {"Time": time_class, "Duration": duration_class}
    if name == "rospy":
        members |= {"get_rostime": now, "get_time": lambda: now().to_sec()}
        members["rostime"] = Module("rospy.rostime", dict(members))
    return Module(name, members)
