"""Finds the services of a site's master that its bridge can serve, and their types: asks their providers."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from itertools import islice
from time import monotonic
from typing import NamedTuple

from pyros1.bridge.exchange.services.served import LocalService
from pyros1.bridge.protocol.packet_values import PacketError, read_md5, read_type
from pyros1.doctor.concurrent import run_concurrently
from pyros1.graph import Graph, SystemState, probe_service
from pyros1.ground.errors import ServiceUnavailableError

_QUERY_TIME = 1.0
"""Seconds to wait for the answers of providers."""
_MAX_QUERIES = 32
"""Maximum number of providers that are asked at the same time."""
RETRY_PERIOD = 10.0
"""Seconds after which a provider that did not answer is asked again."""
_Asked = tuple[str, str]  # service and provider


class _Answer(NamedTuple):
    service: LocalService | None
    problem: str
    asked_at: float


class LocalServices:
    """Finds the services that nodes other than bridges provide, and asks each provider once for the type.

    Args:
        graph: asks the master.
        is_served: returns whether rules allow a service to be called by any other site.
        probe: asks a provider; for tests.

    Attributes:
        problems: service -> why it cannot be served.
    """

    def __init__(
        self,
        graph: Graph,
        is_served: Callable[[str], bool],
        probe: Callable[[str, str, str, float], dict[str, str]] = probe_service,
    ) -> None:
        self.problems: dict[str, str] = {}
        self._graph = graph
        self._is_served = is_served
        self._probe = probe
        self._answers: dict[_Asked, _Answer] = {}
        self._outdated: set[str] = set()

    def check(self, service: str) -> None:
        """Ask the provider of a service again, since a call has failed. Called in any thread."""
        self._outdated.add(service)

    def services(self, state: SystemState, bridges: Collection[str]) -> list[LocalService]:
        """Return the services that can be served.

        Args:
            state: the state of the master.
            bridges: the nodes that are bridges.
        """
        current = {
            (service, nodes[0])
            for service, nodes in state.services.items()
            if nodes and nodes[0] not in bridges and self._is_served(service)
        }
        outdated, self._outdated = self._outdated, set()
        now = monotonic()
        self._answers = {asked: answer for asked, answer in self._answers.items() if asked in current}
        due = [asked for asked in sorted(current) if asked[0] in outdated or self._is_due(asked, now)]
        due.sort(key=self._asked_at)  # providers that never answer must not keep others waiting
        queries = {asked: partial(self._ask, *asked) for asked in islice(due, _MAX_QUERIES)}
        for asked, reply in run_concurrently(queries, _QUERY_TIME).items():
            if isinstance(reply, LocalService):
                self._answers[asked] = _Answer(reply, "", now)
            else:
                self._answers[asked] = _Answer(None, str(reply), now)
        self.problems = {asked[0]: answer.problem for asked, answer in self._answers.items() if answer.problem}
        return [answer.service for answer in self._answers.values() if answer.service is not None]

    def _is_due(self, asked: _Asked, now: float) -> bool:
        answer = self._answers.get(asked)
        return answer is None or (answer.service is None and now - answer.asked_at >= RETRY_PERIOD)

    def _asked_at(self, asked: _Asked) -> float:
        answer = self._answers.get(asked)
        return float("-inf") if answer is None else answer.asked_at

    def _ask(self, service: str, node: str) -> LocalService:
        uri = self._graph.service_uri(service)
        if uri is None:
            raise ServiceUnavailableError(f"{node} no longer provides it")
        header = self._probe(service, uri, self._graph.master.caller_id, _QUERY_TIME)
        try:
            type_name, md5sum = read_type(header.get("type")), read_md5(header.get("md5sum"))
            # rospy does not report the following two types.
            request = read_type(header.get("request_type", f"{type_name}Request"))
            response = read_type(header.get("response_type", f"{type_name}Response"))
        except PacketError:
            raise ServiceUnavailableError(f"{node} does not report its type") from None
        return LocalService(service, str(type_name), str(md5sum), str(request), str(response), node)
