"""Checks whether the program is exiting, and lets callbacks declare their keys and outcomes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

_SHUTDOWN_CHECK: list[Callable[[], bool]] = [lambda: False]


def is_shutdown() -> bool:
    """Return whether the program is exiting, in which case containers stop after the current state."""
    return _SHUTDOWN_CHECK[0]()


def set_shutdown_check(cb: Callable[[], bool]) -> None:
    """Replace the function that `is_shutdown` calls; ``import smach_ros`` sets ``rospy.is_shutdown``."""
    _SHUTDOWN_CHECK[0] = cb


def has_smach_interface(obj: object) -> bool:
    """Return whether an object has methods that return its outcomes, input keys and output keys."""
    names = ("get_registered_input_keys", "get_registered_output_keys", "get_registered_outcomes")
    return all(hasattr(obj, name) for name in names)


class CBInterface:
    """A callback, with the outcomes and keys that it adds to the state that calls it.

    Args:
        cb: the callback.
        outcomes: additional outcomes that it may return.
        input_keys: userdata that it reads.
        output_keys: userdata that it writes.
        io_keys: userdata that it reads and writes.
    """

    def __init__(
        self,
        cb: Callable[..., Any],
        outcomes: Iterable[str] | None = None,
        input_keys: Iterable[str] | None = None,
        output_keys: Iterable[str] | None = None,
        io_keys: Iterable[str] | None = None,
    ) -> None:
        both = tuple(io_keys or ())
        self._cb = cb
        self._outcomes = tuple(outcomes or ())
        self._input_keys = (*(input_keys or ()), *both)
        self._output_keys = (*(output_keys or ()), *both)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self._cb(*args, **kwargs)

    def get_registered_outcomes(self) -> tuple[str, ...]:
        """Return the outcomes that the callback may return."""
        return self._outcomes

    def get_registered_input_keys(self) -> tuple[str, ...]:
        """Return the keys that the callback reads."""
        return self._input_keys

    def get_registered_output_keys(self) -> tuple[str, ...]:
        """Return the keys that the callback writes."""
        return self._output_keys


class cb_interface:
    """Decorator that declares the outcomes and keys of a callback: see `CBInterface`."""

    def __init__(
        self,
        outcomes: Iterable[str] | None = None,
        input_keys: Iterable[str] | None = None,
        output_keys: Iterable[str] | None = None,
    ) -> None:
        self._declared = (outcomes, input_keys, output_keys)

    def __call__(self, cb: Callable[..., Any]) -> CBInterface:
        return CBInterface(cb, *self._declared)


__all__ = ["CBInterface", "cb_interface", "has_smach_interface", "is_shutdown", "set_shutdown_check"]
