"""The TCP links of a delivery: it opens, closes and reads them, and registers them with a driver."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pyros1.ground.errors import ProtocolError
from pyros1.msgs.large_arrays import SplitBody

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from pyros1.node.subscribing.drivers import Channel, Driver
    from pyros1.node.subscribing.tcp_source import TcpSource


class Links:
    """The TCP links of a delivery. Only its owner may use them, except to read `driver`.

    Args:
        channel: the delivery.
        driver: waits for the links.
        on_closed: called with each link that is closed.
        on_lost: called with (link, reason) when a link has ended; reason is None for an orderly end.
    """

    def __init__(
        self,
        channel: Channel,
        driver: Driver,
        on_closed: Callable[[TcpSource], None],
        on_lost: Callable[[TcpSource, str | None], None],
    ) -> None:
        self.driver = driver
        self._channel = channel
        self._on_closed = on_closed
        self._on_lost = on_lost
        self._links: dict[int, TcpSource] = {}

    def __len__(self) -> int:
        return len(self._links)

    def __iter__(self) -> Iterator[TcpSource]:
        return iter(list(self._links.values()))

    def get(self, fd: int) -> TcpSource | None:
        """Return the link with that descriptor, None if it is closed."""
        return self._links.get(fd)

    def open(self, link: TcpSource) -> list[tuple[int, int]]:
        """Start waiting for a new link; return the frames that came together with its header."""
        if self.driver.cooperative:
            link.can_wait = False
        self._links[link.fd] = link
        self.driver.register(link.fd, self._channel)
        return self._split(link, 0)

    def rearm(self, link: TcpSource) -> None:
        """Wait for a link again, unless it is closed."""
        if self._links.get(link.fd) is link:
            self.driver.rearm(link.fd)

    def move(self, driver: Driver) -> None:
        """Move the links to another driver."""
        for fd in self._links:
            self.driver.unregister(fd)
        self.driver = driver
        for fd in self._links:
            driver.register(fd, self._channel)

    def close(self, link: TcpSource) -> None:
        """Close a link, without reporting it as lost."""
        if self._links.pop(link.fd, None) is not None:
            link.connected = False
            self._on_closed(link)
            self.driver.unregister(link.fd)
            link.close()

    def receive(self, link: TcpSource, wait: bool = False) -> list[tuple[int, int]] | SplitBody | None:
        """Receive once from a link.

        Args:
            wait: whether to wait for a moment, see `TcpSource.receive`.

        Returns:
            The frames in the link's buffer, or a large message; None if nothing has come, or the link was lost.
        """
        try:
            received = link.receive(wait)
        except BlockingIOError:
            return None
        except OSError as error:
            self._lose(link, error.strerror or str(error))
            return None
        if isinstance(received, SplitBody):
            return received
        if not received:
            self._lose(link, None)
            return None
        return self._split(link, received)

    def _split(self, link: TcpSource, count: int) -> list[tuple[int, int]]:
        try:
            return link.split(count)
        except ProtocolError as error:
            self._lose(link, str(error))
            return []

    def _lose(self, link: TcpSource, reason: str | None) -> None:
        if link.fd in self._links:
            self.close(link)
            self._on_lost(link, reason)
