"""Sites without a bridge: zenoh's own sessions with keys, which may send, subscribe to and claim anything."""

from __future__ import annotations

import json
import os
import queue
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from pyros1.bridge.rules.router_config import parse_router_config
from pyros1.bridge.rules.site_access import SiteAccess
from pyros1.bridge.transport.access_control import security_settings
from pyros1.bridge.transport.certificates import load_keys
from pyros1.bridge.transport.zenoh_link import make_config

from ..conftest import PATIENCE

ROOT = "pyros1/1/"
SUBSCRIPTIONS = ("**", "pyros1/1/**", "pyros1/1/*/t/**", "pyros1/1/*/to/*", "pyros1/1/*/again/**", "pyros1/1/*/call/**")
MODES = pytest.mark.parametrize("mode", ["client", "peer", "router"])


class Station:
    """A session of zenoh with keys.

    Args:
        keys: the folder of its keys.
        mode: ``client``, ``peer`` or ``router``.
        access: what others may do here; empty for everything.
        connect, listen: endpoints.
    """

    def __init__(
        self,
        keys: Path,
        mode: str = "client",
        access: Sequence[SiteAccess] = (),
        connect: Sequence[str] = (),
        listen: Sequence[str] = (),
    ) -> None:
        import zenoh

        settings = security_settings(load_keys(keys), access, load_keys(keys).site)
        config = make_config(zenoh, "router" if listen else "client", connect, listen, settings)
        config.insert_json5("mode", json.dumps(mode))
        config.insert_json5("connect/timeout_ms", str(-1 if listen else round(1000 * PATIENCE)))
        self._came: queue.Queue[tuple[str, bytes]] = queue.Queue()
        self.session: Any = zenoh.open(config)
        for key in SUBSCRIPTIONS:
            self.session.declare_subscriber(key, self._on_sample, allowed_origin=zenoh.Locality.REMOTE)

    def _on_sample(self, sample: Any) -> None:
        self._came.put((str(sample.key_expr).removeprefix(ROOT), sample.payload.to_bytes()))

    def put(self, key: str, body: bytes = b"") -> None:
        """Put a sample on a key below the protocol's root, or on another one if it begins with a slash."""
        self.session.put(key[1:] if key.startswith("/") else ROOT + key, body)

    def delete(self, key: str) -> None:
        """Delete a key below the protocol's root."""
        self.session.delete(ROOT + key)

    def heard(self, end: str, ask: Callable[[bytes], object]) -> set[str]:
        """Return the keys of what comes to a question.

        Args:
            end: the key of what is sent last, which must come.
            ask: puts samples with the given body. It is called again until `end` comes, and then once more.
        """
        for _ in range(round(PATIENCE / 0.2)):
            if self._heard_once(end, ask, 0.2) is not None:
                keys = self._heard_once(end, ask, PATIENCE)
                assert keys is not None
                return keys
        raise AssertionError(f"{end} did not come")

    def _heard_once(self, end: str, ask: Callable[[bytes], object], patience: float) -> set[str] | None:
        body = os.urandom(8)
        ask(body)
        found = set()
        with suppress(queue.Empty):
            while True:
                key, came = self._came.get(timeout=patience)
                if came == body:
                    if key == end:
                        return found
                    found.add(key)
        return None

    def heard_nothing(self) -> bool:
        """Return whether nothing has come."""
        return self._came.empty()

    def close(self) -> None:
        """End the session."""
        self.session.close()


def access_of(sites: str) -> tuple[SiteAccess, ...]:
    """Return what sites may do, from the text of a file's setting."""
    return parse_router_config(f"sites: {sites}", "f").access


def put_all(station: Station, *keys: str) -> Callable[[bytes], None]:
    """Return a question for `Station.heard`: it puts a sample on each key."""
    return lambda body: [station.put(key, body) for key in keys] and None
