"""Containers: states that contain states (https://wiki.ros.org/smach/Documentation)."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from smach.exceptions import InvalidStateError, InvalidTransitionError
from smach.log import logerr, logwarn
from smach.state import State
from smach.user_data import Remapper, UserData


class _OpenContainers(threading.local):
    """The containers that a thread has opened; states are added to the last one."""

    def __init__(self) -> None:
        self.stack: list[Container] = []


_OPEN_CONTAINERS = _OpenContainers()


class Container(State):
    """Base class of containers.

    ``with container:`` opens the container: the static methods of its class then add states to it.
    Callbacks are called when the container starts, when its active states change, and when it ends.

    Attributes:
        userdata: the data that its states share.
    """

    def __init__(
        self, outcomes: Iterable[str] = (), input_keys: Iterable[str] = (), output_keys: Iterable[str] = ()
    ) -> None:
        super().__init__(outcomes, input_keys, output_keys)
        self.userdata = UserData()
        self._callbacks: dict[str, list[tuple[Callable[..., object], Sequence[Any]]]] = {
            "start": [],
            "transition": [],
            "termination": [],
        }

    # Methods that each kind of container implements -------------------------------------------------------------------

    def __getitem__(self, key: str) -> State:
        """Return a state by its label; raise KeyError if there is no such state."""
        return self.get_children()[key]

    def get_children(self) -> dict[str, State]:
        """Return the states by their labels."""
        raise NotImplementedError

    def set_initial_state(self, initial_states: Sequence[str], userdata: UserData | None = None) -> None:
        """Set the states that run first, and add values to this container's userdata."""
        raise NotImplementedError

    def get_initial_states(self) -> list[str]:
        """Return the labels of the states that run first."""
        raise NotImplementedError

    def get_active_states(self) -> list[str]:
        """Return the labels of the running states."""
        raise NotImplementedError

    def get_internal_edges(self) -> list[tuple[str, str, str]]:
        """Return (outcome, label of the state, target label or outcome) for each transition."""
        raise NotImplementedError

    def check_consistency(self) -> None:
        """Raise InvalidStateError or InvalidTransitionError if the container cannot run."""
        raise NotImplementedError

    # Userdata ---------------------------------------------------------------------------------------------------------

    def set_userdata(self, userdata: UserData) -> None:
        """Add values to this container's userdata."""
        self.userdata.update(userdata)

    def _make_userdata_view(self, state: State, remapping: Mapping[str, str] | None = None) -> Remapper:
        """Return the userdata as one of the states sees it."""
        inputs, outputs = state.get_registered_input_keys(), state.get_registered_output_keys()
        return Remapper(self.userdata, inputs, outputs, remapping)

    def _copy_input_keys(self, parent_ud: Any, ud: Any) -> None:
        if parent_ud is not None:
            self._copy(parent_ud, ud, self.get_registered_input_keys(), "input")

    def _copy_output_keys(self, ud: Any, parent_ud: Any) -> None:
        if parent_ud is not None:
            self._copy(ud, parent_ud, self.get_registered_output_keys(), "output")

    def _copy(self, source: Any, target: Any, keys: Iterable[str], direction: str) -> None:
        for key in keys:
            try:
                value = source[key]
            except KeyError:
                logwarn(f"Attempting to copy {direction} key '{key}', but this key does not exist.")
            else:
                target[key] = value

    # Callbacks --------------------------------------------------------------------------------------------------------

    def register_start_cb(self, start_cb: Callable[..., object], cb_args: Sequence[Any] = ()) -> None:
        """Call ``start_cb(userdata, labels of the first states, *cb_args)`` when the container starts."""
        self._callbacks["start"].append((start_cb, cb_args))

    def register_transition_cb(self, transition_cb: Callable[..., object], cb_args: Sequence[Any] = ()) -> None:
        """Call ``transition_cb(userdata, labels of the active states, *cb_args)`` when these change."""
        self._callbacks["transition"].append((transition_cb, cb_args))

    def register_termination_cb(self, termination_cb: Callable[..., object], cb_args: Sequence[Any] = ()) -> None:
        """Call ``termination_cb(userdata, labels of the last states, outcome, *cb_args)`` when the container ends."""
        self._callbacks["termination"].append((termination_cb, cb_args))

    def call_start_cbs(self) -> None:
        """Call the start callbacks."""
        self._call("start", self.get_initial_states())

    def call_transition_cbs(self) -> None:
        """Call the transition callbacks."""
        self._call("transition", self.get_active_states())

    def call_termination_cbs(self, terminal_states: Sequence[str], outcome: str | None) -> None:
        """Call the termination callbacks."""
        self._call("termination", terminal_states, outcome)

    def _call(self, event: str, *args: Any) -> None:
        for callback, extra in list(self._callbacks[event]):
            try:
                callback(self.userdata, *args, *extra)
            except Exception as error:  # noqa: BLE001  the machine continues
                logerr(f"Could not execute {event} callback: {type(error).__name__}: {error}")

    # Construction -----------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Start adding states; ``with`` calls this."""
        _OPEN_CONTAINERS.stack.append(self)

    def close(self) -> None:
        """Stop adding states; inconsistencies are logged as errors.

        Raises:
            InvalidStateError: another container was opened later, or this one is not open.
        """
        if self.is_opened():
            _OPEN_CONTAINERS.stack.pop()
            self._is_consistent()
        else:
            raise InvalidStateError("Attempting to close a container that is not the one opened last.")

    def is_opened(self) -> bool:
        """Return whether the container is open, so that states can be added to it."""
        return bool(_OPEN_CONTAINERS.stack) and _OPEN_CONTAINERS.stack[-1] is self

    def assert_opened(self, msg: str = "") -> None:
        """Raise InvalidStateError if the container is not open."""
        if not self.is_opened():
            raise InvalidStateError(msg or "The container is not open.")

    @contextmanager
    def opened(self) -> Iterator[Container]:
        """Open the container in a ``with`` block."""
        with self:
            yield self

    def __enter__(self) -> Any:
        self.open()
        return self

    def __exit__(self, exc_type: Any, exc_val: Any, exc_tb: Any) -> None:
        if exc_type is None:
            self.close()
        elif self in _OPEN_CONTAINERS.stack:  # also removes inner containers that the program left open
            del _OPEN_CONTAINERS.stack[_OPEN_CONTAINERS.stack.index(self) :]

    @classmethod
    def _currently_opened_container(cls) -> Any:
        """Return the container to which states are added; raise InvalidStateError if it is not of this class."""
        if not _OPEN_CONTAINERS.stack:
            raise InvalidStateError("No container is open: add states within 'with container:'.")
        container = _OPEN_CONTAINERS.stack[-1]
        if not isinstance(container, cls):
            raise InvalidStateError(f"The open container is not a {cls.__name__}: it is a {type(container).__name__}.")
        return container

    def _is_consistent(self) -> bool:
        try:
            self.check_consistency()
        except (InvalidStateError, InvalidTransitionError) as error:
            logerr(str(error))
            logerr("Container consistency check failed.")
            return False
        return True


__all__ = ["Container"]
