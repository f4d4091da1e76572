"""State machines: one state after the other (https://wiki.ros.org/smach/Tutorials/StateMachine%20container)."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from smach.container import Container
from smach.exceptions import InvalidStateError, InvalidTransitionError, InvalidUserCodeError
from smach.log import logerr, loginfo, logwarn
from smach.state import State
from smach.user_data import UserData
from smach.util import is_shutdown

Transitions = Mapping[str, "str | None"]


class StateMachine(Container):
    """A container that runs one state after the other; it starts with the first one added.

    A state's outcome leads to the label in its transitions, or to an outcome of the machine. Without a transition, or
    with None, it leads to the machine's outcome of the same name.

    Args:
        outcomes: outcomes of the machine.
        input_keys: userdata that it takes from its parent when it starts.
        output_keys: userdata that it passes to its parent when it ends.
    """

    def __init__(
        self, outcomes: Iterable[str], input_keys: Iterable[str] = (), output_keys: Iterable[str] = ()
    ) -> None:
        super().__init__(outcomes, input_keys, output_keys)
        self._states: dict[str, State] = {}
        self._transitions: dict[str, dict[str, str | None]] = {}
        self._remappings: dict[str, Mapping[str, str]] = {}
        self._connectors: tuple[str, ...] = ()  # outcomes of the last state that lead to the next state
        self._last_label = ""
        self._initial_state_label: str | None = None
        self._current_label: str | None = None
        self._is_running = False
        self._state_lock = threading.Lock()

    # Construction -----------------------------------------------------------------------------------------------------

    @staticmethod
    def add(label: str, state: State, transitions: Transitions | None = None, remapping: Any = None) -> State:
        """Add a state to the machine that is open.

        Args:
            label: name of the state in this machine.
            state: the state.
            transitions: outcome of the state -> label, outcome of the machine, or None.
            remapping: the state's name of a userdata key -> the machine's name.

        Raises:
            InvalidStateError: the label is already used, or no machine is open.
            InvalidTransitionError: a transition is for an outcome that the state does not have.
        """
        machine: StateMachine = StateMachine._currently_opened_container()
        return machine._add(label, state, transitions or {}, remapping or {}, ())

    @staticmethod
    def add_auto(
        label: str,
        state: State,
        connector_outcomes: Iterable[str],
        transitions: Transitions | None = None,
        remapping: Any = None,
    ) -> State:
        """Add a state like `add`; the outcomes in ``connector_outcomes`` lead to the state that is added next."""
        machine: StateMachine = StateMachine._currently_opened_container()
        return machine._add(label, state, transitions or {}, remapping or {}, tuple(connector_outcomes))

    def _add(
        self,
        label: str,
        state: State,
        transitions: Transitions,
        remapping: Mapping[str, str],
        connectors: tuple[str, ...],
    ) -> State:
        if label in self._states:
            raise InvalidStateError(
                f'Attempting to add state with label "{label}" to state machine, but this label is already being used.'
            )
        self.check_state_spec(label, state, {**transitions, **dict.fromkeys(connectors)})
        for outcome in self._connectors:
            self._transitions[self._last_label][outcome] = label
        self._connectors, self._last_label = connectors, label
        self._states[label] = state
        self._transitions[label] = {**dict.fromkeys(state.get_registered_outcomes()), **transitions}
        self._remappings[label] = remapping
        if self._initial_state_label is None:
            self._initial_state_label = label
        return state

    def check_state_spec(self, label: str, state: State, transitions: Transitions) -> None:
        """Raise InvalidTransitionError if a transition is for an outcome that the state does not have."""
        unknown = [outcome for outcome in transitions if outcome not in state.get_registered_outcomes()]
        if unknown:
            raise InvalidTransitionError(
                f"State '{label}' has transitions for outcomes that it does not have: {unknown}. "
                f"Its outcomes: {list(state.get_registered_outcomes())}."
            )

    def check_consistency(self) -> None:
        """Raise InvalidStateError or InvalidTransitionError if the machine cannot run."""
        if self._initial_state_label is None:
            raise InvalidStateError("State machine has no initial state: it has no states.")
        if self._initial_state_label not in self._states:
            raise InvalidStateError(f"The initial state '{self._initial_state_label}' is not in the state machine.")
        valid_targets = {*self._states, *self._outcomes, None}
        dangling = [
            f"\n\t'{label}':'{outcome}'-->'{target}'"
            for label, transitions in self._transitions.items()
            for outcome, target in transitions.items()
            if target not in valid_targets
        ]
        if dangling:
            raise InvalidTransitionError(
                f"State machine failed consistency check: these transitions lead to no state and no outcome:"
                f"{''.join(dangling)}\n\tStates: {list(self._states)}\n\tOutcomes: {list(self._outcomes)}"
            )

    # Running ----------------------------------------------------------------------------------------------------------

    def execute(self, parent_ud: Any = None) -> Any:
        """Run the machine.

        Args:
            parent_ud: userdata of the parent.

        Returns:
            The machine's outcome; None if the program exited first, or if the machine is inconsistent, which is logged
            as an error.

        Raises:
            InvalidUserCodeError: a state raised an exception.
            InvalidTransitionError: a state returned an undeclared outcome, or one without a target.
        """
        if not self._is_consistent():
            return None
        self._is_running = True
        outcome = None
        try:
            self._copy_input_keys(parent_ud, self.userdata)
            with self._state_lock:
                self._current_label = label = self._initial_state_label or ""
            keys = self.userdata.keys()
            loginfo(f"State machine starting in initial state '{label}' with userdata: \n\t{keys}")
            self.call_start_cbs()
            if self.preempt_requested():
                self._states[label].request_preempt()
            while outcome is None and self._is_running and not is_shutdown():
                label = self._current_label or ""
                outcome = self._step(label)
            if outcome is not None:
                self._copy_output_keys(self.userdata, parent_ud)
                self.call_termination_cbs([label], outcome)
        finally:
            with self._state_lock:
                self._is_running = False
                self._current_label = None
        return outcome

    def _step(self, label: str) -> str | None:
        """Run a state, and go to the next one; return the machine's outcome if there is no next one."""
        state = self._states[label]
        state_outcome = self._run(label, state)
        if state_outcome is None and is_shutdown():
            return None  # the state is a machine that has ended with the program
        if state_outcome not in state.get_registered_outcomes():
            raise InvalidTransitionError(
                f"Attempted to return outcome '{state_outcome}' from state '{label}' of type "
                f"'{type(state).__name__}' which only has registered outcomes: {list(state.get_registered_outcomes())}"
            )
        target = self._transitions[label].get(state_outcome)
        if target is None:
            target = state_outcome
        if target in self._states:
            self._enter(label, target)
            loginfo(f"State machine transitioning '{label}':'{state_outcome}'-->'{target}'")
            self.call_transition_cbs()
            return None
        if target not in self._outcomes:
            raise InvalidTransitionError(
                f"Outcome '{state_outcome}' of state '{label}' leads to '{target}', which is neither a state nor an "
                f"outcome of the state machine. States: {list(self._states)}, outcomes: {list(self._outcomes)}."
            )
        self._enter(label, None)
        loginfo(f"State machine terminating '{label}':'{state_outcome}':'{target}'")
        return target

    def _run(self, label: str, state: State) -> Any:
        try:
            return state.execute(self._make_userdata_view(state, self._remappings[label]))
        except InvalidUserCodeError:
            logerr(f"State '{label}' failed to execute.")
            raise
        except Exception as error:
            raise InvalidUserCodeError(
                f"Could not execute state '{label}' of type '{type(state).__name__}': {traceback.format_exc()}"
            ) from error

    def _enter(self, label: str, target: str | None) -> None:
        """Make another state the current one. A preemption that the previous state has not serviced is passed on
        to the new state.
        """
        with self._state_lock:
            if self.preempt_requested():
                if not self._states[label].preempt_requested():
                    self.service_preempt()
                else:
                    self._states[label].recall_preempt()
                    if target is not None:
                        self._states[target].request_preempt()
            self._current_label = target

    def is_running(self) -> bool:
        """Return whether the machine is running."""
        return self._is_running

    def request_preempt(self) -> None:
        """Ask the current state to end early; if it does not service the request, ask the next state, and so on."""
        with self._state_lock:
            super().request_preempt()
            if self._current_label is not None:
                self._states[self._current_label].request_preempt()

    # Introspection ----------------------------------------------------------------------------------------------------

    def get_children(self) -> dict[str, State]:
        """Return the states by their labels."""
        return self._states

    def set_initial_state(self, initial_states: Sequence[str], userdata: UserData | None = None) -> None:
        """Set the one state that runs first, and add values to this machine's userdata."""
        if not initial_states:
            logwarn("Attempting to set initial state of a state machine to an empty list.")
            return
        if len(initial_states) > 1:
            logwarn("A state machine can only have one initial state: taking the first one of several.")
        self._initial_state_label = initial_states[0]
        if userdata is not None:
            self.set_userdata(userdata)

    def get_initial_states(self) -> list[str]:
        """Return the label of the state that runs first, in a list."""
        return [str(self._initial_state_label)]

    def get_active_states(self) -> list[str]:
        """Return the label of the current state, in a list; ``["None"]`` if the machine is not running."""
        return [str(self._current_label)]

    def get_internal_edges(self) -> list[tuple[str, str, str]]:
        """Return (outcome, label of the state, target label or outcome) for each transition."""
        return [
            (outcome, label, outcome if target is None else target)
            for label, transitions in self._transitions.items()
            for outcome, target in transitions.items()
        ]


__all__ = ["StateMachine"]
