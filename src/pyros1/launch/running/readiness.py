"""Implements ``wait-for``: checks whether the topics, services, parameters and nodes that nodes wait for exist."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from pyros1.ground.errors import Error
from pyros1.launch.reading.conditions import Condition
from pyros1.net.master_client import MasterClient, is_system_state

_CALLER = "/roslaunch"
_POLL_PERIOD = 0.1


@dataclass
class _WaitingNode:
    conditions: Sequence[Condition]
    timeout: float
    deadline: float
    on_ready: Callable[[], object]
    on_timeout: Callable[[str], object]


class ConditionWatcher:
    """Polls the master while nodes are waiting, with one call for all nodes.

    Args:
        master_uri: the master's URI.
        run_in_supervisor: runs a function in the supervisor's thread.
    """

    def __init__(self, master_uri: str, run_in_supervisor: Callable[[Callable[[], object]], object]) -> None:
        self._master = MasterClient(_CALLER, master_uri)
        self._run_in_supervisor = run_in_supervisor
        self._waiting_nodes: list[_WaitingNode] = []
        self._lock = threading.Lock()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="wait-for", daemon=True)

    def add(
        self,
        conditions: Sequence[Condition],
        timeout: float,
        on_ready: Callable[[], object],
        on_timeout: Callable[[str], object],
    ) -> None:
        """Add a waiting node.

        Args:
            conditions: the conditions that the node waits for.
            timeout: maximum number of seconds to wait; 0 for no limit.
            on_ready: called when all conditions are met.
            on_timeout: called after the timeout with the unmet conditions, as one string.
        """
        deadline = time.monotonic() + timeout if timeout > 0 else float("inf")
        with self._lock:
            self._waiting_nodes.append(_WaitingNode(conditions, timeout, deadline, on_ready, on_timeout))
        if not self._thread.is_alive():
            self._thread.start()

    def close(self) -> None:
        """Stop polling, and remove all waiting nodes. No callbacks are called afterwards."""
        self._closed.set()
        if self._thread.is_alive():
            self._thread.join()
        self._master.close()

    def _run(self) -> None:
        while not self._closed.is_set():
            with self._lock:
                waiting = list(self._waiting_nodes)
            unmet = self._find_unmet({condition for node in waiting for condition in node.conditions})
            for node in waiting:
                unmet_conditions = [condition for condition in node.conditions if condition in unmet]
                if not unmet_conditions:
                    self._run_in_supervisor(node.on_ready)
                elif time.monotonic() >= node.deadline:
                    self._run_in_supervisor(partial(node.on_timeout, ", ".join(map(str, unmet_conditions))))
                else:
                    continue
                with self._lock:
                    self._waiting_nodes.remove(node)
            self._closed.wait(_POLL_PERIOD)

    def _find_unmet(self, conditions: set[Condition]) -> set[Condition]:
        """Return the conditions that are not met; all of them if the master does not respond."""
        if not conditions:
            return set()
        params = [condition for condition in conditions if condition.kind == "param"]
        calls: list[tuple[str, Sequence[str]]] = [("getSystemState", ())]
        calls += [("hasParam", (condition.name,)) for condition in params]
        try:
            state, *has_params = self._master.multicall(calls)
        except Error:
            return conditions
        if not is_system_state(state):
            return conditions
        publishers, subscribers, services = state
        existing = {Condition("topic", name) for name, _ in publishers}
        existing |= {Condition("service", name) for name, _ in services}
        existing |= {
            Condition("node", node)
            for registrations in (publishers, subscribers, services)
            for _, nodes in registrations
            for node in nodes
        }
        existing |= {condition for condition, exists in zip(params, has_params, strict=True) if exists is True}
        return conditions - existing
