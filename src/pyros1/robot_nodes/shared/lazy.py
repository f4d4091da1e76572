"""Subscribes to a node's inputs only while its output has subscribers."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from pyros1.ground.errors import NodeShutdownError
from pyros1.node.publishing.publisher import Publisher


class LazyInputs:
    """Opens inputs when a publisher gets its first subscriber, and closes them when the last one has left.

    Args:
        output: the publisher.
        open_inputs: subscribes, and returns a function that unsubscribes. Both are called in one other thread.
    """

    def __init__(self, output: Publisher[Any], open_inputs: Callable[[], Callable[[], object]]) -> None:
        self._output = output
        self._open_inputs = open_inputs
        self._close_inputs: Callable[[], object] | None = None
        self._watch = output.watch(joined=self._update, left=self._update)

    def _update(self, _: object) -> None:
        with suppress(NodeShutdownError):
            if self._output.num_connections and self._close_inputs is None:
                self._close_inputs = self._open_inputs()
            elif not self._output.num_connections and self._close_inputs is not None:
                close_inputs, self._close_inputs = self._close_inputs, None
                close_inputs()
