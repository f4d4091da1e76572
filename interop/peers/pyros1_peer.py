"""The pyros1 peer of the interop tests, on the Node API: ``pyros1_peer.py NODE_NAME [remappings]``."""

from __future__ import annotations

import sys
from typing import Any

from peer_core import UNSET, Backend, Peer, read_commands
from samples import Samples

from pyros1 import AnyMsg, Duration, Node, Time
from pyros1.ground.errors import Error, ParameterNotSetError, WaitTimeoutError
from pyros1.msgs import load_message, load_service


class NodeBackend(Backend):
    """A pyros1 node behind the peer's commands."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.samples = Samples(lambda name: load_message(name)(), Time, Duration)

    def advertise(self, topic: str, type_name: str, queue_size: int, latch: bool) -> Any:
        return self.node.advertise(topic, type_name, queue_size=queue_size, latch=latch)

    def subscribe(self, topic: str, type_name: str, queue_size: int, callback: Any) -> Any:
        wanted = AnyMsg if type_name == "*" else type_name
        return self.node.subscribe(topic, wanted, callback, queue_size=queue_size or None)

    def links(self, endpoint: Any) -> int:
        return int(endpoint.num_connections)

    def serve(self, name: str, type_name: str, handler: Any) -> Any:
        return self.node.advertise_service(name, type_name, handler)

    def unserve(self, server: Any) -> None:
        server.shutdown()

    def new_request(self, type_name: str) -> Any:
        return load_service(type_name)._request_class()

    def new_response(self, type_name: str) -> Any:
        return load_service(type_name)._response_class()

    def client(self, name: str, type_name: str, persistent: bool) -> Any:
        return self.node.service(name, type_name, persistent=persistent)

    def available(self, name: str, timeout: float) -> bool:
        try:
            self.node.wait_for_service(name, timeout=timeout)
        except WaitTimeoutError:
            return False
        return True

    def set_param(self, key: str, value: Any) -> None:
        self.node.params.set(key, value)

    def get_param(self, key: str) -> Any:
        return self.node.params.get(key, UNSET)

    def cached_param(self, key: str) -> Any:
        return self.node.params.cached(key, UNSET)

    def has_param(self, key: str) -> bool:
        return key in self.node.params

    def delete_param(self, key: str) -> bool:
        try:
            del self.node.params[key]
        except ParameterNotSetError:
            return False
        return True

    def search_param(self, key: str) -> Any:
        return self.node.params.search(key)

    def log(self, level: str, text: str) -> None:
        getattr(self.node.log, level)(text)

    def close(self) -> None:
        self.node.shutdown()


def main() -> int:
    name, *arguments = sys.argv[1:]
    try:
        with Node(name, argv=arguments) as node:
            commands = read_commands()
            node.on_shutdown(lambda: commands.put(None))
            Peer(NodeBackend(node)).run(node.name, commands)
    except Error as problem:
        print(f"ERROR: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
