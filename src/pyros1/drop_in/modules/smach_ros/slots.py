"""Goals and requests from userdata, and userdata from results and responses: for action states and service states."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from smach.exceptions import InvalidStateError
from smach.state import State


class Call(NamedTuple):
    """A function of the program, and its extra arguments."""

    function: Callable[..., Any] | None
    args: Sequence[Any] = ()
    kwargs: Mapping[str, Any] | None = None

    def __call__(self, *args: Any) -> Any:
        """Call the function, if there is one."""
        if self.function is None:
            return None
        return self.function(*args, *self.args, **(self.kwargs or {}))


class CallState(State):
    """Base of the states that send a message and get one back; outcomes "succeeded", "aborted" and "preempted".

    Args:
        what: "goal" or "request", "result" or "response", for error messages.
        first: the message to send if nothing changes it.
        out: userdata key of the whole message to send; keys that are fields of it; function that changes it.
        back: userdata key for the message that came back; keys that are fields of it; function that sees it.
        keys: further input keys, output keys and outcomes.
    """

    def __init__(
        self,
        what: tuple[str, str],
        first: Any,
        out: tuple[str | None, Iterable[str], Call],
        back: tuple[str | None, Iterable[str], Call],
        keys: tuple[Iterable[str], Iterable[str], Iterable[str]],
    ) -> None:
        inputs, outputs, outcomes = keys
        super().__init__(("succeeded", "aborted", "preempted"), inputs, outputs)
        self.register_outcomes(outcomes)
        self._first = first
        self._out_key, slots, self._out_call = out
        self._back_key, back_slots, self._back_call = back
        self._out_slots, self._back_slots = tuple(slots), tuple(back_slots)
        for name, call in zip(what, (self._out_call, self._back_call), strict=True):
            if call.function is not None and not callable(call.function):
                raise InvalidStateError(f"The {name} callback is not a function: {call.function!r}")
            self._register_interface(call.function)
        self.register_input_keys(([self._out_key] if self._out_key else []) + [*self._out_slots])
        self.register_output_keys(([self._back_key] if self._back_key else []) + [*self._back_slots])

    def _message(self, ud: Any) -> Any:
        """Return the message to send: from its key, then its slots, then the function."""
        message = copy.deepcopy(ud[self._out_key] if self._out_key else self._first)
        for slot in self._out_slots:
            setattr(message, slot, ud[slot])
        changed = self._out_call(ud, message)
        return message if changed is None else changed

    def _keep(self, ud: Any, message: Any) -> None:
        """Store the received message in the userdata."""
        if self._back_key:
            ud[self._back_key] = message
        for slot in self._back_slots:
            ud[slot] = getattr(message, slot)


__all__ = ["Call", "CallState"]
