"""Concurrences: all states run simultaneously (https://wiki.ros.org/smach/Tutorials/Concurrence%20container)."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from smach.container import Container
from smach.exceptions import InvalidStateError, InvalidTransitionError, InvalidUserCodeError
from smach.log import logerr, loginfo, logwarn
from smach.state import State
from smach.user_data import UserData
from smach.util import is_shutdown

Outcomes = dict[str, Any]


class Concurrence(Container):
    """A container that runs all its states simultaneously, each in a thread, and ends when all have ended.

    Its outcome is the value that ``outcome_cb`` returns. If that is None, it is the first outcome in ``outcome_map``
    whose states all ended with the outcomes listed there (entries that name all states come first), or the default.

    Args:
        outcomes: outcomes of the concurrence.
        default_outcome: outcome if nothing else determines one.
        input_keys, output_keys: userdata keys that it takes from its parent, and that it passes to its parent.
        outcome_map: outcome of the concurrence -> {label: outcome of that state}.
        outcome_cb: called when all states have ended, with {label: outcome}.
        child_termination_cb: called whenever a state ends, with {label: outcome, or None for a running state}; if it
            returns a true value, all running states are preempted. None to preempt no states.
    """

    def __init__(
        self,
        outcomes: Iterable[str],
        default_outcome: str,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        outcome_map: Mapping[str, Mapping[str, str]] | None = None,
        outcome_cb: Callable[[Outcomes], str | None] | None = None,
        child_termination_cb: Callable[[Outcomes], bool] | None = None,
    ) -> None:
        super().__init__(outcomes, input_keys, output_keys)
        self._default_outcome = default_outcome
        self._outcome_map = dict(outcome_map or {})
        self._outcome_cb = outcome_cb
        self._child_termination_cb = child_termination_cb
        for callback in (outcome_cb, child_termination_cb):
            self._register_interface(callback)
        self._states: dict[str, State] = {}
        self._remappings: dict[str, Mapping[str, str]] = {}
        self._child_outcomes: Outcomes = {}
        self._error: Exception | None = None
        self._is_running = False
        self._preempted_late = False  # whether a preemption was requested after the last state had ended
        self._state_lock = threading.RLock()
        self._callback_lock = threading.Lock()

    @staticmethod
    def add(label: str, state: State, remapping: Mapping[str, str] | None = None) -> State:
        """Add a state to the concurrence that is open.

        Args:
            label: name of the state in this container.
            state: the state.
            remapping: the state's name of a userdata key -> the container's name.

        Raises:
            InvalidStateError: the label is already used, or no concurrence is open.
        """
        self = Concurrence._currently_opened_container()
        if label in self._states:
            raise InvalidStateError(
                f'Attempting to add state with label "{label}" to concurrence, but this label is already being used.'
            )
        self._states[label] = state
        self._remappings[label] = remapping or {}
        return state

    def add_outcome_map(self, outcome_map: Mapping[str, Mapping[str, str]]) -> None:
        """Add to the outcome map."""
        self._outcome_map.update(outcome_map)

    # Running ----------------------------------------------------------------------------------------------------------

    def execute(self, parent_ud: Any = None) -> Any:
        """Run all states, and return the outcome; None if the program exited before there was an outcome.

        Raises:
            InvalidStateError: a state or ``child_termination_cb`` raised an exception, or a state returned a value that
                is not one of its outcomes.
            InvalidUserCodeError: ``outcome_cb`` raised an exception, or returned a value that is not an outcome.
        """
        if not self._is_consistent():
            return None
        self._copy_input_keys(parent_ud, self.userdata)
        loginfo(f"Concurrence starting with userdata: \n\t{self.userdata.keys()}")
        self._error = None
        threads = [
            threading.Thread(target=self._run, args=(label, state), name=f"concurrent_split:{label}", daemon=True)
            for label, state in self._states.items()
        ]
        with self._state_lock:
            self._child_outcomes = dict.fromkeys(self._states)
            self._is_running = True
            self._preempted_late = False
            preempted = self.preempt_requested()
        try:
            self.call_start_cbs()
            if preempted:
                self._preempt_children()
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()  # returns, since each thread ends with its state, and the states end with the node
        finally:
            self._finish()
        if self._error is not None:
            raise InvalidStateError(f"A concurrent state failed: {self._error}") from self._error
        if None in self._child_outcomes.values():
            return None
        outcome = self._determine_outcome()
        loginfo(f"Concurrent Outcomes: {self._child_outcomes}")
        self._copy_output_keys(self.userdata, parent_ud)
        self.call_termination_cbs(list(self._states), outcome)
        return outcome

    def _run(self, label: str, state: State) -> None:
        """Run one of the states. This is executed in the state's own thread."""
        try:
            outcome = state.execute(self._make_userdata_view(state, self._remappings[label]))
            if outcome is None and is_shutdown():
                return  # the state is a container that has ended with the program
            if outcome not in state.get_registered_outcomes():
                raise InvalidTransitionError(
                    f"Attempted to return outcome '{outcome}' from concurrent state '{label}' which only has "
                    f"registered outcomes: {list(state.get_registered_outcomes())}"
                )
            with self._state_lock:
                self._child_outcomes[label] = outcome
            must_preempt = self._should_terminate()
        except Exception as error:  # noqa: BLE001  the waiting thread raises it
            logerr(f"Concurrent state '{label}' failed: {traceback.format_exc()}")
            with self._state_lock:
                self._error = self._error or error
            self._preempt_children()
            return
        if must_preempt:
            self._preempt_children()
        self.call_transition_cbs()

    def _should_terminate(self) -> bool:
        """Call ``child_termination_cb``, in one thread at a time; return whether running states are to be preempted."""
        if self._child_termination_cb is None:
            return False
        with self._callback_lock:
            return bool(self._child_termination_cb(dict(self._child_outcomes)))

    def _preempt_children(self) -> None:
        with self._state_lock:
            for label in self.get_active_states():
                self._states[label].request_preempt()

    def _finish(self) -> None:
        """Recall preemption requests that states have not serviced; if there are none, service the container's own."""
        with self._state_lock:
            self._is_running = False
            unserviced = [state for state in self._states.values() if state.preempt_requested()]
            for state in unserviced:
                state.recall_preempt()
            if not unserviced and not self._preempted_late:
                self.service_preempt()

    def _determine_outcome(self) -> str:
        children = self._child_outcomes
        if self._outcome_cb is not None:
            try:
                callback_outcome = self._outcome_cb(dict(children))
            except Exception as error:
                raise InvalidUserCodeError(f"Could not execute outcome callback: {traceback.format_exc()}") from error
            if callback_outcome is not None:
                if callback_outcome not in self._outcomes:
                    raise InvalidUserCodeError(
                        f"The outcome callback returned '{callback_outcome}', but the outcomes of the concurrence are: "
                        f"{list(self._outcomes)}"
                    )
                return callback_outcome
        entries = sorted(self._outcome_map.items(), key=lambda item: len(item[1]) < len(children))
        for outcome, state_outcomes in entries:  # entries that name all states come first
            if all(children.get(label) == expected for label, expected in state_outcomes.items()):
                return outcome
        return self._default_outcome

    def is_running(self) -> bool:
        """Return whether the concurrence is running."""
        return self._is_running

    def request_preempt(self) -> None:
        """Ask all running states to end early."""
        with self._state_lock:
            super().request_preempt()
            if self._is_running:
                self._preempted_late = not self.get_active_states()
                self._preempt_children()

    # Introspection ----------------------------------------------------------------------------------------------------

    def check_consistency(self) -> None:
        """Raise InvalidStateError or InvalidTransitionError if the outcome map contains unknown labels or outcomes."""
        if not self._states:
            raise InvalidStateError("The concurrence has no states.")
        for outcome in (*self._outcome_map, self._default_outcome):
            if outcome not in self._outcomes:
                raise InvalidTransitionError(
                    f"'{outcome}' is not an outcome of the concurrence: {list(self._outcomes)}"
                )
        for outcome, state_outcomes in self._outcome_map.items():
            for label, state_outcome in state_outcomes.items():
                if label not in self._states:
                    raise InvalidStateError(f"The outcome map of '{outcome}' names '{label}', which is not a state.")
                if state_outcome not in self._states[label].get_registered_outcomes():
                    raise InvalidTransitionError(
                        f"The outcome map of '{outcome}' contains '{state_outcome}', which is not an outcome of state "
                        f"'{label}'."
                    )

    def get_children(self) -> dict[str, State]:
        """Return the states by their labels."""
        return self._states

    def set_initial_state(self, initial_states: Sequence[str], userdata: UserData | None = None) -> None:
        """Add values to this container's userdata. The initial states stay the same: they are all states."""
        if {*initial_states} != {*self._states}:
            logwarn("The initial states of a concurrence cannot be changed: they are all its states.")
        if userdata is not None:
            self.set_userdata(userdata)

    def get_initial_states(self) -> list[str]:
        """Return the labels of all states."""
        return list(self._states)

    def get_active_states(self) -> list[str]:
        """Return the labels of the states that have not ended."""
        return [label for label, outcome in self._child_outcomes.items() if outcome is None]

    def get_internal_edges(self) -> list[tuple[str, str, str]]:
        """Return (outcome, label of the state, outcome of the concurrence) for each entry of the outcome map."""
        return [
            (state_outcome, label, outcome)
            for outcome, state_outcomes in self._outcome_map.items()
            for label, state_outcome in state_outcomes.items()
        ]


__all__ = ["Concurrence"]
