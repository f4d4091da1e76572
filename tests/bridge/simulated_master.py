"""What a simulated site asks of its master, which may be slow or out of order for a while, see `simulation`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from random import Random

from pyros1.bridge.deferred import Change, DeferredActions
from pyros1.bridge.exchange.actions import Action, Forget, Publish
from pyros1.bridge.transport.memory_link import MemoryNetwork


class MasterConditions:
    """How a master responds.

    Attributes:
        delay: maximum seconds until it has done something.
        failures: the share of requests that fail.
    """

    def __init__(self) -> None:
        self.delay = self.failures = 0.0

    def change(self, random: Random) -> None:
        """Let a master become slower or faster, or fail."""
        self.delay = random.choice([0.0, 0.1, 1.0])
        self.failures = random.choice([0.0, 0.0, 0.5])


class SimulatedMaster:
    """Carries out a bridge's actions that need the master, as its thread does.

    Args:
        network: has the time.
        random: decides how long each action takes, and whether it fails.
        conditions: of the master; they may change.
        clock: returns the site's time.
        do: carries out an action.
        act: carries out the messages that have waited for it.
    """

    def __init__(
        self,
        network: MemoryNetwork,
        random: Random,
        conditions: MasterConditions,
        clock: Callable[[], float],
        do: Callable[[Change], None],
        act: Callable[[Iterable[Action]], None],
    ) -> None:
        self._network = network
        self._random = random
        self._conditions = conditions
        self._do = do
        self._act = act
        self._deferred = DeferredActions(clock)
        self._is_busy = self._is_closed = False

    def close(self) -> None:
        """Carry out nothing more, since the bridge was killed."""
        self._is_closed = True

    def put(self, action: Change) -> None:
        """Add an action."""
        self._deferred.put(action)
        if not self._is_busy:
            self._is_busy = True
            self._network.at(self._network.now, self._begin)

    def hold(self, action: Publish | Forget) -> bool:
        """Return whether a message must wait until its topic is published."""
        return self._deferred.hold(action)

    def poll(self) -> None:
        """Try again what has failed, and what had to wait."""
        self._deferred.retry()
        if not self._is_busy:
            self._begin()

    def _begin(self) -> None:
        changes = [] if self._is_closed else self._deferred.pop()
        self._is_busy = bool(changes)
        if changes:
            delay = self._random.uniform(0.0, self._conditions.delay)
            self._network.at(self._network.now + delay, lambda: self._end(changes))

    def _end(self, changes: list[Change]) -> None:
        if self._is_closed:
            return
        for index, change in enumerate(changes):
            if self._random.random() < self._conditions.failures:
                self._deferred.fail(changes[index:])
                break
            self._do(change)
        else:
            if not self._deferred.finish_if_nothing_waits():
                self._act(self._deferred.finish())
        self._begin()
