"""Finds the topics of a site's master that a bridge could send, and their types: asks the master and the publishers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from time import monotonic
from typing import NamedTuple

from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.protocol.packet_values import PacketError, read_md5, read_type
from pyros1.bridge.rules.namespaces import UsedTopics
from pyros1.doctor.bridge_status import STATUS_SERVICE, find_providers
from pyros1.doctor.concurrent import run_concurrently
from pyros1.doctor.facts import ReportedType
from pyros1.doctor.probe import query_publisher
from pyros1.graph import Graph, SystemState
from pyros1.ground.errors import MessageError
from pyros1.ground.terminal_text import one_line

STAND_IN_SERVICE = "bridged_node"
"""Name, below the node's name, of the service that marks a node as a stand-in for another site's node."""
_QUERY_TIME = 1.0
"""Seconds to wait for the answers of publishers."""
_MAX_QUERIES = 32
"""Maximum number of publishers that are asked at the same time."""
ASKING_TIME = 0.5
"""Seconds after which no more publishers are asked before the master is polled again."""
RETRY_PERIOD = 10.0
"""Seconds after which a publisher that did not answer is asked again."""
_SHOWN_LENGTH = 60
"""Maximum length of a type or md5 sum that is not valid, in a description of the problem."""
_Asked = tuple[str, str]  # publisher and topic


class _Answer(NamedTuple):
    """A publisher's answer: the type of its topic, or why it cannot be sent; neither if it has not reported it."""

    type: ReportedType | None
    problem: str
    asked_at: float


def find_bridges(state: SystemState) -> frozenset[str]:
    """Return the names of the nodes that are bridges, or stand-ins for other sites' nodes."""
    return frozenset((*find_providers(state, STATUS_SERVICE), *find_providers(state, STAND_IN_SERVICE)))


class LocalGraph:
    """Finds the topics that nodes other than bridges publish, and asks each publisher once for type and definition.

    Args:
        graph: asks the master.
        is_sent: returns whether rules allow a topic to be sent to any other site.
        query: asks a publisher; for tests.

    Attributes:
        bridges: the nodes that are bridges.
        used: the topics that other nodes publish or subscribe to, whether or not they can be sent.
        publishers: the other nodes that, according to the master, publish topics which rules allow to be sent.
        lost: publishers that no longer respond, set by the caller; their topics are left out.
        problems: topic -> why it cannot be sent.
        is_behind: whether some publishers have yet to be asked, since there were too many at once.
        state: the state of the master when it was last asked.
    """

    def __init__(
        self,
        graph: Graph,
        is_sent: Callable[[str], bool],
        query: Callable[[str, str, str], ReportedType] = query_publisher,
    ) -> None:
        self.bridges: frozenset[str] = frozenset()
        self.used = UsedTopics(frozenset(), frozenset())
        self.publishers: frozenset[str] = frozenset()
        self.lost: frozenset[str] = frozenset()
        self.problems: dict[str, str] = {}
        self.is_behind = False
        self.state = SystemState({}, {}, {})
        self._graph = graph
        self._is_sent = is_sent
        self._query = query
        self._answers: dict[_Asked, _Answer] = {}
        self._outdated: set[_Asked] = set()

    def check_type(self, node: str, topic: str, md5sum: str) -> None:
        """Ask a publisher again if its messages have another type than it reported: another node with its name has
        started since. Called in any thread.
        """
        answer = self._answers.get((node, topic))
        if answer is not None and answer.type is not None and answer.type.md5sum != md5sum:
            self._outdated.add((node, topic))

    def topics(self) -> list[LocalTopic]:
        """Return the topics that can be sent.

        Raises:
            Error: the master does not respond.
        """
        self.state = state = self._graph.state()
        self.bridges = find_bridges(state)
        self.used = _used_topics(state, self.bridges | {self._graph.master.caller_id})
        publishers = {
            topic: [node for node in nodes if node not in self.bridges]
            for topic, nodes in state.publishers.items()
            if self._is_sent(topic)
        }
        self.publishers = frozenset(node for nodes in publishers.values() for node in nodes)
        lost = self.lost
        if lost:
            publishers = {topic: [node for node in nodes if node not in lost] for topic, nodes in publishers.items()}
        self._ask(publishers)
        self.problems = {}
        return [topic for name, nodes in publishers.items() if nodes and (topic := self._topic(name, nodes))]

    def _ask(self, publishers: Mapping[str, Iterable[str]]) -> None:
        """Ask publishers that have not answered yet, and forget those that are gone."""
        current = {(node, topic) for topic, nodes in publishers.items() for node in nodes}
        outdated, self._outdated = self._outdated, set()
        self._answers = {
            asked: answer for asked, answer in self._answers.items() if asked in current and asked not in outdated
        }
        now = monotonic()
        due = [
            asked
            for asked in sorted(current)
            if (answer := self._answers.get(asked)) is None
            or (answer.type is None and now - answer.asked_at >= RETRY_PERIOD)
        ]
        due.sort(key=self._asked_at)  # publishers that never answer must not keep others waiting
        # Ask as many as time allows, since each call of this function costs a large response from the master.
        while due:
            queries = {asked: partial(self._ask_publisher, *asked) for asked in due[:_MAX_QUERIES]}
            del due[:_MAX_QUERIES]
            for asked, reply in run_concurrently(queries, _QUERY_TIME).items():
                self._answers[asked] = _check(reply, now)
            if monotonic() - now >= ASKING_TIME:
                break
        self.is_behind = bool(due)

    def _asked_at(self, asked: _Asked) -> float:
        answer = self._answers.get(asked)
        return float("-inf") if answer is None else answer.asked_at

    def _ask_publisher(self, node: str, topic: str) -> ReportedType:
        uri = self._graph.node_uri(node)
        if uri is None:
            raise MessageError(f"{node} is gone")
        return self._query(self._graph.master.caller_id, uri, topic)

    def _topic(self, name: str, nodes: list[str]) -> LocalTopic | None:
        answers = [answer for node in nodes if (answer := self._answers.get((node, name)))]
        problem = next((answer.problem for answer in answers if answer.problem), "")
        types = [answer.type for answer in answers if answer.type]
        if not types:
            self.problems[name] = problem or "its publishers have not reported its type"
            return None
        first = types[0]
        same = [each for each in types if each.md5sum == first.md5sum]
        if problem or len(same) < len(types):
            self.problems[name] = f"messages of other types than {first.type} are left out"
        definition = next((each.definition for each in same if each.definition), "")
        latched = any(each.latched for each in same)
        return LocalTopic(name, first.type, first.md5sum, definition, latched, tuple(nodes))


def _used_topics(state: SystemState, bridges: frozenset[str]) -> UsedTopics:
    """Return the topics that nodes other than bridges use."""
    tables = (state.publishers, state.subscribers)
    return UsedTopics(
        *(frozenset(topic for topic, nodes in table.items() if not bridges.issuperset(nodes)) for table in tables)
    )


def _check(reply: ReportedType | Exception, now: float) -> _Answer:
    """Return a publisher's answer. Other sites refuse a whole list of topics if one type or md5 sum is not valid."""
    if not isinstance(reply, ReportedType) or reply.failure is not None or "*" in (reply.type, reply.md5sum):
        return _Answer(None, "", now)
    try:
        read_type(reply.type)
        read_md5(reply.md5sum)
    except PacketError as error:
        type_name, md5sum = (one_line(text, _SHOWN_LENGTH) for text in (reply.type, reply.md5sum))
        return _Answer(None, f"a publisher reports the type {type_name} with md5 sum {md5sum}: {error}", now)
    return _Answer(reply, "", now)
