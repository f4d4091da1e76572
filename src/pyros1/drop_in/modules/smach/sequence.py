"""Sequences: states that run in the order in which they were added (https://wiki.ros.org/smach/Tutorials/Sequence%20container)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from smach.state import State
from smach.state_machine import StateMachine, Transitions


class Sequence(StateMachine):
    """A state machine in which one outcome of each state leads to the state that was added after it.

    Args:
        outcomes: outcomes of the sequence.
        connector_outcome: the outcome that leads to the next state.
        input_keys, output_keys: userdata keys that it takes from its parent, and that it passes to its parent.
    """

    def __init__(
        self,
        outcomes: Iterable[str],
        connector_outcome: str,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
    ) -> None:
        super().__init__(outcomes, input_keys, output_keys)
        self._connector_outcome = connector_outcome

    @staticmethod
    def add(label: str, state: State, transitions: Transitions | None = None, remapping: Any = None) -> State:
        """Add a state to the open sequence; a transition for the connector outcome replaces the transition to the next
        state.

        For the arguments and errors, see `StateMachine.add`.
        """
        return StateMachine.add(label, state, transitions, remapping)

    def _add(self, label: str, state: State, transitions: Transitions, remapping: Any, connectors: Any) -> State:
        connector = self._connector_outcome
        if (
            connector not in connectors
            and connector not in transitions
            and connector in state.get_registered_outcomes()
        ):
            connectors = (*connectors, connector)
        return super()._add(label, state, transitions, remapping, connectors)


__all__ = ["Sequence"]
