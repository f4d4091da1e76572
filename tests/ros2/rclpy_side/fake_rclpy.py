"""The part of rclpy's API that a bridge uses, in one process and without ROS 2: for tests of what we do with it.

Encoded messages are their ``data``. All nodes share a `Network`. Executors do as rclpy's: tasks, and callbacks that
wait, go on when the executor is woken.
"""

from __future__ import annotations

import queue
import sys
import threading
from collections.abc import Callable, Generator
from enum import IntEnum
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

GID = "gid of 16 bytes."


class HistoryPolicy(IntEnum):
    KEEP_LAST, KEEP_ALL = 1, 2


class ReliabilityPolicy(IntEnum):
    RELIABLE, BEST_EFFORT = 1, 2


class DurabilityPolicy(IntEnum):
    TRANSIENT_LOCAL, VOLATILE = 1, 2


QOS = SimpleNamespace(
    HistoryPolicy=HistoryPolicy,
    ReliabilityPolicy=ReliabilityPolicy,
    DurabilityPolicy=DurabilityPolicy,
    QoSProfile=SimpleNamespace,
)


class Message:
    """A message of any type."""

    def __init__(self, data: bytes = b"") -> None:
        self.data = data


def deserialize(data: bytes, message_class: type[Message]) -> Message:
    assert isinstance(data, bytes)
    return message_class(data)


class Future:
    def __init__(self, *, executor: Any = None) -> None:
        self._callbacks: list[Callable[[Any], object]] = []
        self._is_done = False
        self._result: Any = None
        self._error: Exception | None = None

    def done(self) -> bool:
        return self._is_done

    def result(self) -> Any:
        return self._result

    def set_result(self, result: Any) -> None:
        assert not self._is_done
        self._result, self._is_done = result, True
        for callback in self._callbacks:
            callback(self)

    def set_exception(self, error: Exception) -> None:
        assert not self._is_done
        self._error, self._is_done = error, True

    def add_done_callback(self, callback: Callable[[Any], object]) -> None:
        self._callbacks.append(callback)
        if self._is_done:
            callback(self)

    def __await__(self) -> Generator[None, None, Any]:
        while not self._is_done:
            yield
        if self._error is not None:
            raise self._error
        return self._result


class SingleThreadedExecutor:
    """Runs tasks in the thread that calls `spin_once`."""

    def __init__(self, *, context: Any) -> None:
        self._tasks: queue.Queue[Any] = queue.Queue()
        self._waiting: list[tuple[Any, Callable[[Any], object]]] = []

    def add_node(self, node: Any) -> None:
        node.executor = self

    def remove_node(self, node: Any) -> None:
        assert node.executor is self

    def create_task(self, callback: Callable[..., Any], *args: Any) -> None:
        self._tasks.put((callback, args))

    def run(self, coroutine: Any, finish: Callable[[Any], object]) -> None:
        """Begin an asynchronous callback; `finish` gets what it returns."""
        self.create_task(lambda: self._waiting.append((coroutine, finish)))
        self.create_task(lambda: None)

    def spin_once(self) -> None:
        callback, args = self._tasks.get(timeout=30)
        for each in [*self._waiting]:
            try:
                each[0].send(None)
            except StopIteration as end:
                self._waiting.remove(each)
                each[1](end.value)
            except BaseException:
                self._waiting.remove(each)
                self._tasks.put((callback, args))
                raise
        callback(*args)

    def shutdown(self, timeout_sec: float | None = None) -> None:
        pass


class Network:
    """What all nodes have.

    Attributes:
        nodes, publishers, subscriptions, services, clients: all of them.
        errors: node, topic or service -> what is raised when something is made with this name.
        hashes: topic -> the hash of its type, as DDS tells it.
        contexts: those that were not shut down.
    """

    def __init__(self, tells_publishers: bool = True) -> None:
        self.tells_publishers = tells_publishers
        self.nodes: list[tuple[str, str]] = []
        self.publishers: list[Any] = []
        self.subscriptions: list[Any] = []
        self.services: list[Any] = []
        self.clients: list[Any] = []
        self.errors: dict[str, Exception] = {}
        self.hashes: dict[str, str] = {}
        self.contexts: list[Any] = []
        self.domains: list[int | None] = []

    def publish(self, topic: str, body: bytes, gid: bytes) -> None:
        """Publish a message of a ROS 2 node."""
        info = {"source_timestamp": 7} | ({"publisher_gid": {"data": gid}} if self.tells_publishers else {})
        for each in [*self.subscriptions]:
            if each.name == topic:
                each.node.executor.create_task(each.receive, body, info)

    def call(self, name: str, data: bytes) -> queue.Queue[bytes]:
        """Call a service, and return what gets its response."""
        (service,) = (each for each in self.services if each.name == name)
        responses: queue.Queue[bytes] = queue.Queue()
        coroutine = service.callback(service.type.Request(data), service.type.Response())
        service.node.executor.run(coroutine, lambda response: responses.put(response.data))
        return responses


class Node:
    """rclpy's node."""

    executor: Any

    def __init__(self, network: Network, name: str, namespace: str = "/", **_: Any) -> None:
        if name in network.errors:
            raise network.errors[name]
        self._network = network
        self._name = (name, namespace)
        self.threads: set[str] = set()
        network.nodes.append(self._name)

    def destroy_node(self) -> None:
        self._network.nodes.remove(self._name)

    def _make(self, kind: str, type: Any, name: str, **attributes: Any) -> Any:
        if name in self._network.errors:
            raise self._network.errors[name]
        self.threads.add(threading.current_thread().name)
        made = SimpleNamespace(node=self, type=type, name=name, owner=self._name, gid=GID.encode(), **attributes)
        getattr(self._network, kind).append(made)
        return made

    def create_publisher(self, type: Any, name: str, qos: Any, *, callback_group: Any = None) -> Any:
        made = self._make("publishers", type, name, qos=qos, sent=[])

        def publish(body: bytes) -> None:
            assert isinstance(body, bytes)
            made.sent.append(body)
            self._network.publish(name, body, made.gid)

        made.publish = publish
        return made

    def create_subscription(
        self, type: Any, name: str, callback: Any, qos: Any, *, raw: bool, callback_group: Any
    ) -> Any:
        assert raw
        return self._make("subscriptions", type, name, qos=qos, receive=callback)

    def create_service(self, type: Any, name: str, callback: Any, *, callback_group: Any) -> Any:
        return self._make("services", type, name, callback=callback)

    def create_client(self, type: Any, name: str, *, callback_group: Any) -> Any:
        requests: queue.Queue[tuple[bytes, Future]] = queue.Queue()
        made = self._make("clients", type, name, requests=requests, removed=[], is_ready=True)

        def call_async(request: Message) -> Future:
            future = Future()
            requests.put((request.data, future))
            return future

        made.call_async, made.service_is_ready = call_async, lambda: made.is_ready
        made.remove_pending_request = made.removed.append
        return made

    def destroy_publisher(self, made: Any) -> None:
        self._network.publishers.remove(made)

    def destroy_subscription(self, made: Any) -> None:
        self._network.subscriptions.remove(made)

    def destroy_service(self, made: Any) -> None:
        self._network.services.remove(made)

    def destroy_client(self, made: Any) -> None:
        self._network.clients.remove(made)

    # What there is

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return [*self._network.nodes]

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        ends = [*self._network.publishers, *self._network.subscriptions]
        return [(name, []) for name in sorted({each.name for each in ends})]

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        return self._infos(self._network.publishers, topic)

    def get_subscriptions_info_by_topic(self, topic: str) -> list[Any]:
        return self._infos(self._network.subscriptions, topic)

    def _infos(self, ends: list[Any], topic: str) -> list[Any]:
        return [
            SimpleNamespace(
                node_name=each.owner[0],
                node_namespace=each.owner[1],
                topic_type=each.type if isinstance(each.type, str) else "lab_msgs/msg/Bench",
                topic_type_hash=self._network.hashes.get(topic, "INVALID"),
                endpoint_gid=[*each.gid],
                qos_profile=each.qos,
            )
            for each in ends
            if each.name == topic
        ]

    def get_service_names_and_types_by_node(self, name: str, namespace: str) -> list[tuple[str, list[str]]]:
        return self._of(self._network.services, name, namespace)

    def get_client_names_and_types_by_node(self, name: str, namespace: str) -> list[tuple[str, list[str]]]:
        return self._of(self._network.clients, name, namespace)

    def _of(self, ends: list[Any], name: str, namespace: str) -> list[tuple[str, list[str]]]:
        if name == "gone":
            raise RuntimeError("there is no such node")
        return [(each.name, [each.type]) for each in ends if each.owner == (name, namespace)]


def install(monkeypatch: pytest.MonkeyPatch, *, tells_publishers: bool = True) -> Network:
    """Let rclpy be this one, and return what its nodes have."""
    network = Network(tells_publishers)

    class Context:
        def init(self, *, args: list[str], initialize_logging: bool, domain_id: int) -> None:
            assert args == [] and not initialize_logging
            network.contexts.append(self)
            network.domains.append(domain_id)

        def ok(self) -> bool:
            return self in network.contexts

        def try_shutdown(self) -> None:
            network.contexts.remove(self)

    info: Any = type("MessageInfo", (), {"__annotations__": {"publisher_gid": dict} if tells_publishers else {}})
    contents: dict[str, dict[str, Any]] = {
        "": {},
        ".node": {"Node": lambda name, **options: Node(network, name, **options)},
        ".context": {"Context": Context},
        ".executors": {"SingleThreadedExecutor": SingleThreadedExecutor},
        ".task": {"Future": Future},
        ".qos": vars(QOS),
        ".serialization": {"serialize_message": lambda message: message.data, "deserialize_message": deserialize},
        ".callback_groups": {"ReentrantCallbackGroup": object},
        ".subscription": {"Subscription": SimpleNamespace(CallbackType=1), "MessageInfo": info},
        ".utilities": {"get_rmw_implementation_identifier": lambda: "rmw_of_tests"},
    }
    for name, content in contents.items():
        module = ModuleType(f"rclpy{name}")
        module.__dict__.update(content, __path__=[])
        monkeypatch.setitem(sys.modules, f"rclpy{name}", module)
    return network
