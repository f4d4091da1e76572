"""Keys of sites, and sessions that use them."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.bridge.transport.certificates import make_keys

from .stations import Station


@pytest.fixture
def port() -> int:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        return int(unused.getsockname()[1])


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    folder = tmp_path / "keys"
    hosts = ["127.0.0.1"]
    make_keys(folder, {"red": [], "red-2": [], "green": [], "stranger": [], "base": hosts, "hub": hosts})
    return folder


@pytest.fixture
def make_station(keys: Path) -> Iterator[Callable[..., Station]]:
    """Return a function that makes stations with keys; those that were made last are closed first."""
    stations: list[Station] = []

    def make(name: str, *args: Any, **options: Any) -> Station:
        stations.append(Station(keys / name, *args, **options))
        return stations[-1]

    yield make
    for station in reversed(stations):
        station.close()
