from __future__ import annotations

from pyros1.robot_nodes.rosserial_python.servers import Servers


class Service:
    def __init__(self, log: list[str], name: str) -> None:
        log.append(f"open {name}")
        self._log, self._name = log, name

    def close(self) -> None:
        self._log.append(f"close {self._name}")


def test_the_newest_service_replaces_the_others() -> None:
    log: list[str] = []
    servers = Servers()
    first = servers.replace("/motor", lambda: Service(log, "first"))
    servers.replace("/light", lambda: Service(log, "light"))
    second = servers.replace("/motor", lambda: Service(log, "second"))
    servers.forget(first)
    third = servers.replace("/motor", lambda: Service(log, "third"))
    servers.forget(third)
    assert servers.replace("/motor", lambda: second) is second
    assert log == ["open first", "open light", "close first", "open second", "close second", "open third"]
