"""Peers of a publisher: word of subscribers that come and go, and messages for only one of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.node.watching.telling import Log, Teller

if TYPE_CHECKING:
    from pyros1.node.publishing.linking import Link
    from pyros1.node.publishing.publication import Publication


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


class Watch:
    """Calls functions when subscribers come and go, one call after the other, in a thread of their own.

    Args:
        publication: what is watched.
        joined, left: called with a `Peer`.
        log: for functions that raise.
    """

    def __init__(self, publication: Publication, joined: Told, left: Told, log: Log) -> None:
        self._publication = publication
        self._joined = joined
        self._left = left
        self._known: tuple[Link, ...] = ()
        self._teller = Teller(f"subscribers of {publication.topic}", log, most=None)
        publication.on_change.append(self._look)
        publication.context.loop.call_soon(self._look)  # for those that are here

    def close(self) -> None:
        """Tell no more."""
        self._publication.on_change.remove(self._look)
        self._teller.close()

    def _look(self) -> None:
        """Compare the links with those known. On the loop."""
        links, known = self._publication.links, self._known
        self._known = links
        new = [(self._joined, link) for link in links if link not in known]
        gone = [(self._left, link) for link in known if link not in links]
        for tell, link in gone + new:
            self._teller.tell(tell, Peer(self._publication, link, sum(other is not link for other in links)))
