"""States: units of work that containers run, and that return an outcome (https://wiki.ros.org/smach/Documentation)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from smach.util import has_smach_interface


class State:
    """Base class of a program's states, which override `execute`.

    Args:
        outcomes: what `execute` may return.
        input_keys: userdata that it reads.
        output_keys: userdata that it writes.
        io_keys: userdata that it reads and writes.
    """

    def __init__(
        self,
        outcomes: Iterable[str] = (),
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        io_keys: Iterable[str] = (),
    ) -> None:
        both = tuple(io_keys)
        # Dictionaries used as ordered sets.
        self._outcomes = dict.fromkeys(outcomes)
        self._input_keys = dict.fromkeys((*input_keys, *both))
        self._output_keys = dict.fromkeys((*output_keys, *both))
        self._preempt_requested = False

    def execute(self, ud: Any) -> Any:
        """Do the work of the state.

        Args:
            ud: the userdata that the state declared.

        Returns:
            One of the outcomes.
        """
        raise NotImplementedError

    def register_outcomes(self, new_outcomes: Iterable[str]) -> None:
        """Add outcomes."""
        self._outcomes.update(dict.fromkeys(new_outcomes))

    def get_registered_outcomes(self) -> tuple[str, ...]:
        """Return the outcomes."""
        return tuple(self._outcomes)

    def register_io_keys(self, keys: Iterable[str]) -> None:
        """Add keys that are read and written."""
        both = tuple(keys)
        self.register_input_keys(both)
        self.register_output_keys(both)

    def register_input_keys(self, keys: Iterable[str]) -> None:
        """Add keys that are read."""
        self._input_keys.update(dict.fromkeys(keys))

    def get_registered_input_keys(self) -> tuple[str, ...]:
        """Return the keys that are read."""
        return tuple(self._input_keys)

    def register_output_keys(self, keys: Iterable[str]) -> None:
        """Add keys that are written."""
        self._output_keys.update(dict.fromkeys(keys))

    def get_registered_output_keys(self) -> tuple[str, ...]:
        """Return the keys that are written."""
        return tuple(self._output_keys)

    def _register_interface(self, cb: Any) -> None:
        """Add what a callback declares with `smach.cb_interface`."""
        if has_smach_interface(cb):
            self.register_outcomes(cb.get_registered_outcomes())
            self.register_input_keys(cb.get_registered_input_keys())
            self.register_output_keys(cb.get_registered_output_keys())

    def request_preempt(self) -> None:
        """Ask the state to end early; its `execute` can check this with `preempt_requested`."""
        self._preempt_requested = True

    def service_preempt(self) -> None:
        """Report that the state has handled the request made with `request_preempt`."""
        self._preempt_requested = False

    def recall_preempt(self) -> None:
        """Cancel the request made with `request_preempt`."""
        self._preempt_requested = False

    def preempt_requested(self) -> bool:
        """Return whether the state was asked to end early."""
        return self._preempt_requested


class CBState(State):
    """A state that calls a function: ``cb(userdata, *cb_args, **cb_kwargs)`` returns the outcome.

    Outcomes and keys that the function declares with `smach.cb_interface` are added to the arguments.
    """

    def __init__(
        self,
        cb: Callable[..., Any],
        cb_args: Sequence[Any] = (),
        cb_kwargs: Mapping[str, Any] | None = None,
        outcomes: Iterable[str] = (),
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        io_keys: Iterable[str] = (),
    ) -> None:
        super().__init__(outcomes, input_keys, output_keys, io_keys)
        self._cb = cb
        self._cb_args = cb_args
        self._cb_kwargs = cb_kwargs or {}
        self._register_interface(cb)

    def execute(self, ud: Any) -> Any:
        """Call the function."""
        return self._cb(ud, *self._cb_args, **self._cb_kwargs)


__all__ = ["CBState", "State"]
