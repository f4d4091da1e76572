"""Peers of a publisher: word of subscribers that come and go, and messages for only one of them."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from pyros1.node.publishing.publication import Link, Publication


class Peer:
    """A subscriber of a publisher, as seen by the functions given to ``Publisher.watch``.

    Attributes:
        name: full name of its node.
        others: number of the topic's other subscribers when it came or went.
    """

    def __init__(self, publication: Publication, link: Link, others: int) -> None:
        self.name = link.peer
        self.others = others
        self._publication = publication
        self._link = link

    def publish(self, message: Any) -> None:
        """Send a message to this subscriber only.

        Args:
            message: of the topic's type.

        Raises:
            SerializationError: a value does not fit its field.
        """
        self._publication.publish_to(self._link, message)


Told = Callable[[Peer], object]


class _Log(Protocol):
    def exception(self, text: object, *args: object, error: BaseException | None = None) -> None: ...


class Watch:
    """Calls functions when subscribers come and go, one call after the other.

    The calls are made by a thread that exists while there is something to tell: they are the program's code, which
    must not run on the loop.

    Args:
        publication: what is watched.
        joined, left: called with a `Peer`.
        log: for functions that raise.
    """

    def __init__(self, publication: Publication, joined: Told, left: Told, log: _Log) -> None:
        self._publication = publication
        self._joined = joined
        self._left = left
        self._log = log
        self._known: tuple[Link, ...] = ()
        self._jobs: deque[tuple[Told, Peer]] = deque()
        self._lock = threading.Lock()
        self._busy = False
        publication.on_change.append(self._look)
        publication.context.loop.call_soon(self._look)  # for those that are here

    def close(self) -> None:
        """Tell no more."""
        self._publication.on_change.remove(self._look)
        self._jobs.clear()

    def _look(self) -> None:
        """Compare the links with those known. On the loop."""
        links, known = self._publication.links, self._known
        self._known = links
        new = [(self._joined, link) for link in links if link not in known]
        gone = [(self._left, link) for link in known if link not in links]
        for tell, link in gone + new:
            self._jobs.append((tell, Peer(self._publication, link, sum(other is not link for other in links))))
        with self._lock:
            if self._busy or not self._jobs:
                return
            self._busy = True
        threading.Thread(target=self._run, name=f"{self._publication.topic}:peers", daemon=True).start()

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._jobs:
                    self._busy = False
                    return
                tell, peer = self._jobs.popleft()
            try:
                tell(peer)
            except Exception as error:  # noqa: BLE001 - the program's code: others are still told
                self._log.exception(f"bad function for subscribers of {self._publication.topic}: {tell!r}", error=error)
