"""Notifies a publisher of subscribers that connect and disconnect, and sends messages to single subscribers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.node.watching.notifiers import Log, Notifier

if TYPE_CHECKING:
    from pyros1.node.publishing.publication import Publication
    from pyros1.node.publishing.publisher_links import Link


class Peer:
    """A subscriber, as passed to the functions of ``Publisher.watch``.

    Attributes:
        name: full name of the subscriber's node.
        others: number of the topic's other subscribers when this one connected or disconnected.
    """

    def __init__(self, publication: Publication, link: Link, others: int) -> None:
        self.name = link.peer
        self.others = others
        self._publication = publication
        self._link = link

    def publish(self, message: Any) -> None:
        """Send a message to this subscriber only.

        Args:
            message: a message of the topic's type.

        Raises:
            SerializationError: a value does not fit its field.
        """
        self._publication.publish_to(self._link, message)


PeerCallback = Callable[[Peer], object]


class PeerWatch:
    """Calls functions when subscribers connect and disconnect, one call at a time, in a separate thread.

    Args:
        publication: the publication to watch.
        on_joined, on_left: called with a `Peer`.
        log: logs exceptions raised by the functions.
    """

    def __init__(self, publication: Publication, on_joined: PeerCallback, on_left: PeerCallback, log: Log) -> None:
        self._publication = publication
        self._on_joined = on_joined
        self._on_left = on_left
        self._previous_links: tuple[Link, ...] = ()
        self._notifier = Notifier(f"subscribers of {publication.topic}", log, max_pending=None)
        publication.change_listeners.append(self._update)
        publication.context.loop.call_soon(self._update)  # reports subscribers that are already connected

    def close(self) -> None:
        """Make no further calls."""
        self._publication.change_listeners.remove(self._update)
        self._notifier.close()

    def _update(self) -> None:
        """Report links that were added or removed since the last call. Called on the loop."""
        links, previous_links = self._publication.links, self._previous_links
        self._previous_links = links
        joined = [(self._on_joined, link) for link in links if link not in previous_links]
        left = [(self._on_left, link) for link in previous_links if link not in links]
        for callback, link in left + joined:
            self._notifier.notify(callback, Peer(self._publication, link, sum(other is not link for other in links)))
