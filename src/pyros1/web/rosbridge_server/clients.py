"""Publishes the number and the list of connected clients, on client_count and connected_clients."""

from __future__ import annotations

from typing import Any

from pyros1.msgs.rosbridge_msgs.msg import ConnectedClient, ConnectedClients
from pyros1.msgs.std_msgs.msg import Int32
from pyros1.node import Node


class ClientList:
    """The connected clients. Publishes them, latched, whenever they change.

    Args:
        node: the node that publishes them.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[object, Any] = {}
        self._count_publisher = node.advertise("client_count", Int32, queue_size=10, latch=True)
        self._list_publisher = node.advertise("connected_clients", ConnectedClients, queue_size=10, latch=True)
        self._publish()

    def __len__(self) -> int:
        return len(self._clients)

    def add(self, client: object, address: str) -> None:
        """Add a client that has connected from an IP address."""
        self._clients[client] = ConnectedClient(address, self._node.now())
        self._publish("connected")

    def remove(self, client: object) -> None:
        """Remove a client that has disconnected."""
        self._clients.pop(client, None)
        self._publish("disconnected")

    def _publish(self, event: str = "") -> None:
        if not self._node.ok():  # the node is shutting down, which ends the connections
            return
        self._list_publisher.publish(ConnectedClients(list(self._clients.values())))
        self._count_publisher.publish(len(self))
        if event:
            self._node.log.info("a client has %s: %d in total", event, len(self))
