"""A standalone router: sites that only dial out reach each other through it."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from typing import Any

from pyros1.bridge.transport.connections import Connection, session_connections
from pyros1.bridge.transport.failures import explain_listening
from pyros1.bridge.transport.zenoh_link import CLOSE_TIME, LinkError, check_installed, make_config


class Router:
    """A running router.

    Args:
        connect: endpoints of other routers.
        listen: endpoints to listen on.
        settings: further zenoh settings, as for `pyros1.bridge.transport.zenoh_link.ZenohLink`.

    Raises:
        LinkError: eclipse-zenoh is not installed, cannot listen, or rejects a setting.
    """

    def __init__(self, connect: Sequence[str], listen: Sequence[str], settings: Mapping[str, str]) -> None:
        check_installed()
        import zenoh  # noqa: PLC0415 - large, and only needed to run a router

        try:
            self._session: Any = zenoh.open(make_config(zenoh, "router", connect, listen, settings))
        except zenoh.ZError as error:
            raise LinkError(f"cannot start the router: {explain_listening(error, listen)}") from error

    def connections(self) -> list[Connection]:
        """Return the current connections; none if this version of zenoh cannot tell."""
        return session_connections(self._session)

    def close(self) -> None:
        """Close the connections. This takes at most `CLOSE_TIME`; zenoh's own close may wait for a hung peer."""
        closer = threading.Thread(target=self._session.close, name="close router", daemon=True)
        closer.start()
        closer.join(CLOSE_TIME)
