"""Topics for scenes of what is built on nodes: each subscriber gets its messages in a thread of its own, in order; one
topic may be far behind another; and the links between two nodes can be cut, with all that is on its way, and mended.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

from pyros1.ground.timing import Time

from ...bodies import decode, encode
from ..stage import Stage
from .parts import Log


class Board:
    """All topics of a run.

    Attributes:
        cut_off: whether messages are lost, and links are down.
        cuts: how often that was so.
    """

    def __init__(self, stage: Stage) -> None:
        self.stage = stage
        self.publishers: list[Publisher] = []
        self.subscribers: list[Subscriber] = []
        self.threads: list[Any] = []
        self.cut_off = False
        self.cuts = 0

    def cut(self) -> None:
        """Break all links; what is on its way is lost."""
        self.cut_off = True
        self.cuts += 1
        for subscriber in self.subscribers:
            subscriber.waiting.clear()

    def mend(self) -> None:
        """Make all links again; latched messages come anew."""
        self.cut_off = False
        for publisher in self.publishers:
            for subscriber in publisher.linked():
                publisher.link(subscriber)

    def close(self) -> None:
        """End all threads."""
        for subscriber in list(self.subscribers):
            subscriber.unregister()
        for thread in self.threads:
            thread.join()


class Link(NamedTuple):
    """As a link between nodes.

    Attributes:
        peer: the node at the other end.
        cuts: what differs from link to link.
    """

    peer: str
    cuts: int

    @property
    def header(self) -> dict[str, str]:
        """Connection header of the node at the other end."""
        return {"callerid": self.peer}


class Publisher:
    """As a node's publisher."""

    def __init__(self, board: Board, node: Station, name: str, kind: Any, latch: bool) -> None:
        self.node, self.name, self.kind, self.latch = node, name, kind, latch
        self._board = board
        self._latched = b""
        self.sent: list[Any] = []
        board.publishers.append(self)
        for subscriber in self.linked():
            self.link(subscriber)

    def linked(self) -> list[Subscriber]:
        """Return the subscribers that are linked."""
        if self._board.cut_off or self not in self._board.publishers:
            return []
        return [each for each in self._board.subscribers if each.name == self.name]

    def link(self, subscriber: Subscriber) -> None:
        """Begin with the latched message."""
        if self._latched:
            subscriber.waiting.append((self.node.name, self._latched))

    @property
    def links(self) -> list[Link]:
        """Return the links."""
        return [Link(each.node.name, self._board.cuts) for each in self.linked()]

    @property
    def num_connections(self) -> int:
        """Number of subscribers."""
        return len(self.linked())

    def publish(self, message: Any) -> None:
        """Send a message."""
        body = encode(message)
        self.sent.append(decode(self.kind, body))
        if self.latch:
            self._latched = body
        for subscriber in self.linked():
            subscriber.waiting.append((self.node.name, body))
        self._board.stage.scheduler.point()

    def unregister(self) -> None:
        """End it."""
        if self in self._board.publishers:
            self._board.publishers.remove(self)


class Subscriber:
    """As a node's subscriber."""

    def __init__(self, board: Board, node: Station, name: str, kind: Any, callback: Callable[[Any], None]) -> None:
        self.node, self.name, self.kind = node, name, kind
        self.waiting: deque[tuple[str, bytes]] = deque()  # the publishers' nodes, and messages
        self._board, self._callback = board, callback
        self._over = False
        board.subscribers.append(self)
        for publisher in board.publishers:
            if self in publisher.linked():
                publisher.link(self)
        board.threads += board.stage.spawn(self._deliver)

    @property
    def links(self) -> list[Link]:
        """Return the links."""
        return [Link(each.node.name, self._board.cuts) for each in self._board.publishers if self in each.linked()]

    @property
    def num_connections(self) -> int:
        """Number of publishers."""
        return sum(self in publisher.linked() for publisher in self._board.publishers)

    def _deliver(self) -> None:
        scheduler = self._board.stage.scheduler
        while True:
            scheduler.wait(lambda: self.waiting or self._over)
            if self._over:
                return
            sender, body = self.waiting.popleft()
            message = decode(self.kind, body)
            message._connection_header = {"callerid": sender}
            self._callback(message)

    def unregister(self) -> None:
        """End it."""
        self._over = True
        if self in self._board.subscribers:
            self._board.subscribers.remove(self)


class Timer:
    """As a node's timer."""

    def __init__(self, board: Board, seconds: float, callback: Callable[[Any], object]) -> None:
        self._over = False

        def run() -> None:
            while not board.stage.scheduler.wait(lambda: self._over, seconds):
                callback(None)

        board.threads += board.stage.spawn(run)

    def shutdown(self) -> None:
        """End it."""
        self._over = True


class Station:
    """What actions need of a node.

    Args:
        board: where its topics are.
        name: its full name.
    """

    def __init__(self, board: Board, name: str) -> None:
        self.name = name
        self.log = Log(board.stage)
        self._board = board
        self._topics = self

    def ok(self) -> bool:
        """Return that it runs."""
        return True

    def on_shutdown(self, callback: Callable[[], object]) -> None:
        """Do nothing: it runs as long as the scene."""

    def resolve(self, name: str) -> str:
        """Return a full name."""
        return "/" + name.lstrip("/")

    def now(self) -> Time:
        """Return the time."""
        return Time.from_sec(self._board.stage.time.time())

    def timer(self, seconds: float, callback: Callable[[Any], object]) -> Timer:
        """Call a function again and again."""
        return Timer(self._board, seconds, callback)

    def advertise(self, name: str, kind: Any, queue_size: int, latch: bool = False) -> Publisher:
        """Publish on a topic."""
        return Publisher(self._board, self, self.resolve(name), kind, latch)

    def subscribe(self, name: str, kind: Any, callback: Any, queue_size: int, direct: bool) -> Subscriber:
        """Listen to a topic."""
        return Subscriber(self._board, self, name, kind, callback)
