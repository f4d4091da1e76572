"""Finds the services on a bridge's master, and their types: asks the master and the providers."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import islice
from time import monotonic
from typing import NamedTuple

from pyros1.bridge.local_graph import find_bridges
from pyros1.bridge.plugin_ros1.plan import LocalService
from pyros1.doctor.concurrent import run_concurrently
from pyros1.graph import Graph, probe_service

_QUERY_TIME = 1.0
"""Seconds to wait for the answers of providers."""
_MAX_QUERIES = 32
"""Maximum number of services whose providers are asked at the same time."""
_RETRY_PERIOD = 10.0
"""Seconds after which a provider that did not answer is asked again."""


class _Answer(NamedTuple):
    service: LocalService | None
    asked_at: float


class LocalServices:
    """Finds the services that nodes other than bridges provide, and asks once for the types of those that rules allow
    to be called from elsewhere.

    Args:
        graph: asks the master.
        is_served: returns whether rules allow a service to be called from elsewhere.

    Attributes:
        problems: service -> why it cannot be called from elsewhere.
    """

    def __init__(self, graph: Graph, is_served: Callable[[str], bool]) -> None:
        self.problems: dict[str, str] = {}
        self._graph = graph
        self._is_served = is_served
        self._answers: dict[tuple[str, str], _Answer] = {}  # by service and provider

    def services(self) -> list[LocalService]:
        """Return the services; those that cannot be called from elsewhere have no types.

        Raises:
            Error: the master does not respond.
        """
        state = self._graph.state()
        bridges = find_bridges(state)
        providers = {name: nodes[-1] for name, nodes in state.services.items() if nodes and nodes[-1] not in bridges}
        asked = {(name, node) for name, node in providers.items() if self._is_served(name)}
        self._ask(asked)
        self.problems = {}
        found = []
        for name, node in sorted(providers.items()):
            answer = self._answers.get((name, node))
            if (name, node) in asked and (answer is None or answer.service is None):
                self.problems[name] = "its provider has not reported its type"
            found.append(answer.service if answer and answer.service else LocalService(name))
        return found

    def _ask(self, current: set[tuple[str, str]]) -> None:
        self._answers = {asked: answer for asked, answer in self._answers.items() if asked in current}
        now = monotonic()
        due = [
            asked
            for asked in sorted(current)
            if (answer := self._answers.get(asked)) is None
            or (answer.service is None and now - answer.asked_at >= _RETRY_PERIOD)
        ]
        due.sort(key=self._asked_at)  # providers that never answer must not keep others waiting
        queries = {asked: partial(self._probe, asked[0]) for asked in islice(due, _MAX_QUERIES)}
        for asked, reply in run_concurrently(queries, _QUERY_TIME).items():
            self._answers[asked] = _Answer(reply if isinstance(reply, LocalService) else None, now)

    def _asked_at(self, asked: tuple[str, str]) -> float:
        answer = self._answers.get(asked)
        return float("-inf") if answer is None else answer.asked_at

    def _probe(self, name: str) -> LocalService | None:
        uri = self._graph.service_uri(name)
        if uri is None:
            return None
        header = probe_service(name, uri, self._graph.master.caller_id, _QUERY_TIME)
        return LocalService(name, header.get("type", ""), header.get("md5sum", ""))
