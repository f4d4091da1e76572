"""Iterators: one state, run repeatedly (https://wiki.ros.org/smach/Tutorials/Iterator%20container)."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from smach.container import Container
from smach.exceptions import InvalidStateError, InvalidTransitionError, InvalidUserCodeError
from smach.log import logdebug, logwarn
from smach.state import State
from smach.user_data import UserData
from smach.util import is_shutdown


class Iterator(Container):
    """A container that runs its state once for each item.

    Args:
        outcomes: outcomes of the iterator.
        input_keys, output_keys: userdata keys that it takes from its parent, and that it passes to its parent.
        it: the items, or a function without arguments that returns them when the iterator starts.
        it_label: the userdata key of the current item.
        exhausted_outcome: outcome when there are no more items.
    """

    def __init__(
        self,
        outcomes: Iterable[str],
        input_keys: Iterable[str],
        output_keys: Iterable[str],
        it: Iterable[Any] | Callable[[], Iterable[Any]] = (),
        it_label: str = "it_data",
        exhausted_outcome: str = "exhausted",
    ) -> None:
        super().__init__((*outcomes, exhausted_outcome), input_keys, output_keys)
        self._items = it
        self._items_label = it_label
        self._exhausted_outcome = exhausted_outcome
        self._state_label = ""
        self._state: State | None = None
        self._loop_outcomes: tuple[str, ...] = ()
        self._break_outcomes: tuple[str, ...] = ()
        self._final_outcome_map: Mapping[str, str] = {}
        self._is_running = False
        self._state_lock = threading.Lock()

    @staticmethod
    def set_contained_state(
        label: str,
        state: State,
        loop_outcomes: Iterable[str] = (),
        break_outcomes: Iterable[str] = (),
        final_outcome_map: Mapping[str, str] | None = None,
    ) -> None:
        """Set the state of the iterator that is open.

        Args:
            label: name of the state.
            state: the state.
            loop_outcomes: outcomes after which the iterator continues with the next item; all others end the iterator.
                If there are none, the iterator continues after any outcome.
            break_outcomes: outcomes that end the iterator.
            final_outcome_map: last outcome of the state -> outcome of the iterator, if they differ.
        """
        self = Iterator._currently_opened_container()
        self._state_label, self._state = label, state
        self._loop_outcomes, self._break_outcomes = tuple(loop_outcomes), tuple(break_outcomes)
        self._final_outcome_map = final_outcome_map or {}

    def execute(self, parent_ud: Any = None) -> Any:
        """Run the state for each item, and return the outcome; None if the program exited before that."""
        if not self._is_consistent() or self._state is None:
            return None
        self._is_running = True
        try:
            self._copy_input_keys(parent_ud, self.userdata)
            self.call_start_cbs()
            outcome = self._iterate(self._state)
            if outcome is None:
                return None
            outcome = self._final_outcome_map.get(outcome, outcome)
            if outcome not in self._outcomes:
                raise InvalidTransitionError(
                    f"Iterator state '{self._state_label}' ended with '{outcome}', which is not an outcome of the "
                    f"iterator: {list(self._outcomes)}"
                )
            self._copy_output_keys(self.userdata, parent_ud)
            self.call_termination_cbs([self._state_label], outcome)
            return outcome
        finally:
            with self._state_lock:
                self._is_running = False
                self._state.recall_preempt()  # a preemption was requested after the last item

    def _iterate(self, state: State) -> str | None:
        """Run the state for each item; return its last outcome, or ``exhausted_outcome`` if there are no more items."""
        for item in self._items() if callable(self._items) else self._items:
            if is_shutdown():
                return None
            with self._state_lock:
                if self.preempt_requested():
                    state.request_preempt()
            logdebug(f"Iterator: next item for state '{self._state_label}'")
            self.userdata[self._items_label] = item
            outcome = self._run(state)
            if outcome is None:
                return None
            with self._state_lock:
                if self.preempt_requested():
                    if not state.preempt_requested():
                        self.service_preempt()
                    state.recall_preempt()
                    return outcome
            continues = outcome in self._loop_outcomes or not self._loop_outcomes
            if outcome in self._break_outcomes or not continues:
                return outcome
            self.call_transition_cbs()
        return self._exhausted_outcome

    def _run(self, state: State) -> Any:
        try:
            outcome = state.execute(self._make_userdata_view(state))
        except InvalidUserCodeError:
            raise
        except Exception as error:
            raise InvalidUserCodeError(
                f"Could not execute iterator state '{self._state_label}' of type '{type(state).__name__}': "
                f"{traceback.format_exc()}"
            ) from error
        if outcome is None and is_shutdown():
            return None  # the state is a container that has ended with the program
        if outcome not in state.get_registered_outcomes():
            raise InvalidTransitionError(
                f"Attempted to return outcome '{outcome}' from iterator state '{self._state_label}' which only has "
                f"registered outcomes: {list(state.get_registered_outcomes())}"
            )
        return outcome

    def is_running(self) -> bool:
        """Return whether the iterator is running."""
        return self._is_running

    def request_preempt(self) -> None:
        """Ask the state, and thus the iterator, to end early."""
        with self._state_lock:
            super().request_preempt()
            if self._is_running and self._state is not None:
                self._state.request_preempt()

    def check_consistency(self) -> None:
        """Raise InvalidStateError if there is no state, or InvalidTransitionError if an outcome is not one of the
        state's outcomes.
        """
        if self._state is None:
            raise InvalidStateError("The iterator has no state: use Iterator.set_contained_state.")
        state_outcomes = self._state.get_registered_outcomes()
        for role, names in (("loop", self._loop_outcomes), ("break", self._break_outcomes)):
            unknown = [name for name in names if name not in state_outcomes]
            if unknown:
                raise InvalidTransitionError(f"Iterator state '{self._state_label}' has no {role} outcomes {unknown}.")
        unknown = [name for name in self._final_outcome_map.values() if name not in self._outcomes]
        if unknown:
            raise InvalidTransitionError(f"final_outcome_map has outcomes that the iterator lacks: {unknown}.")

    def get_children(self) -> dict[str, State]:
        """Return {label: state}, with the one state."""
        return {self._state_label: self._state} if self._state is not None else {}

    def set_initial_state(self, initial_states: Sequence[str], userdata: UserData | None = None) -> None:
        """Add values to this container's userdata. The initial state stays the same: there is only one state."""
        if list(initial_states) != self.get_initial_states():
            logwarn("The initial state of an iterator cannot be changed.")
        if userdata is not None:
            self.set_userdata(userdata)

    def get_initial_states(self) -> list[str]:
        """Return the label of the state, in a list."""
        return [self._state_label]

    def get_active_states(self) -> list[str]:
        """Return the label of the state, in a list."""
        return [self._state_label]

    def get_internal_edges(self) -> list[tuple[str, str, str]]:
        """Return (outcome, label of the state, target label or outcome) for each transition."""
        edges = [(self._exhausted_outcome, self._state_label, self._exhausted_outcome)]
        for outcome in self._state.get_registered_outcomes() if self._state is not None else ():
            continues = outcome in self._loop_outcomes or not self._loop_outcomes
            if continues and outcome not in self._break_outcomes:
                edges.append((outcome, self._state_label, self._state_label))
            else:
                edges.append((outcome, self._state_label, self._final_outcome_map.get(outcome, outcome)))
        return edges


__all__ = ["Iterator"]
