"""The base class of action and service states: builds messages from userdata, and stores received messages in it."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from smach.exceptions import InvalidStateError
from smach.state import State


class UserCallback(NamedTuple):
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
    """Base class of states that send a message and receive another one; outcomes "succeeded", "aborted" and
    "preempted".

    Args:
        message_names: names of both messages in error messages: ("goal", "result") or ("request", "response").
        default: the message to send if nothing changes it.
        sent: how the message to send is built: (userdata key of the whole message, userdata keys that are fields of the
            message, function that changes the message).
        received: how the received message is used: (userdata key for the whole message, userdata keys for its fields,
            function that is called with the message).
        keys: additional input keys, output keys and outcomes.
    """

    def __init__(
        self,
        message_names: tuple[str, str],
        default: Any,
        sent: tuple[str | None, Iterable[str], UserCallback],
        received: tuple[str | None, Iterable[str], UserCallback],
        keys: tuple[Iterable[str], Iterable[str], Iterable[str]],
    ) -> None:
        inputs, outputs, outcomes = keys
        super().__init__(("succeeded", "aborted", "preempted"), inputs, outputs)
        self.register_outcomes(outcomes)
        self._default = default
        self._sent_key, sent_slots, self._sent_callback = sent
        self._received_key, received_slots, self._received_callback = received
        self._sent_slots, self._received_slots = tuple(sent_slots), tuple(received_slots)
        for name, callback in zip(message_names, (self._sent_callback, self._received_callback), strict=True):
            if callback.function is not None and not callable(callback.function):
                raise InvalidStateError(f"The {name} callback is not a function: {callback.function!r}")
            self._register_interface(callback.function)
        self.register_input_keys(([self._sent_key] if self._sent_key else []) + [*self._sent_slots])
        self.register_output_keys(([self._received_key] if self._received_key else []) + [*self._received_slots])

    def _make_message(self, ud: Any) -> Any:
        """Return the message to send: the one in the userdata or else the default, after setting its fields from the
        userdata and calling the function.
        """
        message = copy.deepcopy(ud[self._sent_key] if self._sent_key else self._default)
        for slot in self._sent_slots:
            setattr(message, slot, ud[slot])
        changed = self._sent_callback(ud, message)
        return message if changed is None else changed

    def _store(self, ud: Any, message: Any) -> None:
        """Store the received message in the userdata."""
        if self._received_key:
            ud[self._received_key] = message
        for slot in self._received_slots:
            ud[slot] = getattr(message, slot)


__all__ = ["CallState", "UserCallback"]
