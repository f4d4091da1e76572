"""Subscribes to a node's inputs only while its outputs have subscribers."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from pyros1.ground.errors import NodeShutdownError
from pyros1.node.publishing.peers import Peer
from pyros1.node.publishing.publisher import Publisher

OpenInputs = Callable[[], Sequence[Callable[[], object]]]
"""A function that subscribes, and returns functions that unsubscribe."""


class LazyInputs:
    """Opens inputs when the publishers get their first subscriber, and closes them when the last one has left.

    Args:
        outputs: the publishers.
        open_inputs: opens the inputs. It and the functions that it returns are called in a separate thread.
    """

    def __init__(self, outputs: Sequence[Publisher[Any]], open_inputs: OpenInputs) -> None:
        self._open_inputs = open_inputs
        self._closers: Sequence[Callable[[], object]] | None = None
        self._wanted: set[int] = set()  # the indices of the outputs that have subscribers
        self._lock = threading.Lock()
        self._watches = [
            output.watch(joined=partial(self._on_joined, index), left=partial(self._on_left, index))
            for index, output in enumerate(outputs)
        ]

    def _on_joined(self, index: int, _: Peer) -> None:
        with self._lock, suppress(NodeShutdownError):
            self._wanted.add(index)
            if self._closers is None:
                self._closers = self._open_inputs()

    def _on_left(self, index: int, peer: Peer) -> None:
        # Do not use the current number of subscribers: one that comes and goes in between causes no callback.
        with self._lock, suppress(NodeShutdownError):
            if not peer.others:
                self._wanted.discard(index)
            if not self._wanted and self._closers is not None:
                closers, self._closers = self._closers, None
                for close in closers:
                    close()
