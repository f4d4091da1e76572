"""What a router logs about connections."""

from __future__ import annotations

from pyros1.bridge.transport.connections import Connection, Connections

RED = Connection("1", "red", "10.0.0.2:5")


def lines(connections: Connections, *found: Connection) -> list[str]:
    """Return what is logged."""
    return ["WARNING: " * event.is_warning + event.text for event in connections.update(found)]


def test_who_comes_and_goes() -> None:
    connections = Connections(["red", "blue-2"])
    assert lines(connections) == []
    assert lines(connections, RED) == ["site red connected (10.0.0.2:5)"]
    assert lines(connections, RED) == []
    blue = Connection("2", "blue-2", "10.0.0.3:5")
    assert lines(connections, blue) == [
        "site red disconnected (10.0.0.2:5)",
        "site blue (keys blue-2) connected (10.0.0.3:5)",
    ]


def test_the_same_keys_twice() -> None:
    connections = Connections([])
    lines(connections, RED)
    again = RED._replace(zid="2", address="10.0.0.9:5")
    assert lines(connections, RED, again) == [
        "site red connected (10.0.0.9:5); there is another connection with the same keys"
    ]
    unnamed = [Connection(zid, "", f"127.0.0.1:{zid}") for zid in "34"]
    assert lines(connections, RED, again, *unnamed) == [
        "somebody without keys connected (127.0.0.1:3)",
        "somebody without keys connected (127.0.0.1:4)",
    ]


def test_those_who_are_not_named() -> None:
    connections = Connections(["red-2"])
    (line,) = lines(connections, RED)
    assert line.startswith("WARNING: site red connected (10.0.0.2:5): it is not named under `sites`")
    (line,) = lines(connections, RED, Connection("2", "\x1b[2J", "1.2.3.4:5"))
    assert line.startswith("WARNING: somebody with keys of '\\x1b[2J' connected")
