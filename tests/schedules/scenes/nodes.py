"""Whole nodes and their master: they start, meet, change their minds, take each other's names and end."""

from __future__ import annotations

from typing import Any, ClassVar

from pyros1.ground.errors import NodeShutdownError
from pyros1.master.server import Master
from pyros1.msgs.std_msgs.msg import UInt64
from pyros1.node import Node
from pyros1.node.log.levels import ERROR
from pyros1.node.log.sink import LogSink, Record

from ..stage import Scenario, Stage
from .parts import PUBLISHING, SUBSCRIBING, check_orders

MESSAGES = 4
EVERY_PART = (
    *PUBLISHING,
    *SUBSCRIBING,
    *(
        f"pyros1.node.{name}"
        for name in ("shutdown", "registrar", "topics", "slave", "server", "context", "callback_queue")
    ),
    "pyros1.node.subscribing.connector",
    "pyros1.node.subscribing.dialogue",
    "pyros1.node.publishing.local_link",
    "pyros1.net.rpc_caller",
    "pyros1.net.xmlrpc_client",
    "pyros1.master.notify",
)


class QuietSink(LogSink):
    """Keeps what a node logs, and writes nothing.

    Attributes:
        records: of all nodes of the run.
    """

    records: ClassVar[list[Record]] = []

    def emit(self, record: Record, *_: object, **__: object) -> None:
        """Keep a record."""
        self.records.append(record)


class Nodes(Scenario):
    """What the scenes with nodes have in common."""

    modules = EVERY_PART
    limits: tuple[tuple[str, str, Any], ...] = (
        ("pyros1.node.node", "LogSink", QuietSink),
        ("pyros1.master.server", "SPIN_TIME", 0.0),
    )

    def play(self, stage: Stage) -> None:
        """Play it, and look for errors in the logs."""
        QuietSink.records.clear()
        self.act(stage, self.start_master())
        bad = [record.text for record in QuietSink.records if record.level >= ERROR]
        assert not bad, bad

    def start_master(self, port: int = 0) -> Master:
        """Return a running master."""
        master = Master(port=port, bind_host="127.0.0.1")
        master.start()
        return master

    def act(self, stage: Stage, master: Master) -> None:
        """Play it."""
        raise NotImplementedError

    def node(self, name: str, master: Master, **options: Any) -> Node:
        """Return a node."""
        environ = {"ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "localhost"}
        return Node(name, argv=[], environ=environ, handle_signals=False, rosout=False, **options)


class Meeting(Nodes):
    """A talker and a listener start and end at the same time; what is published once they have met arrives."""

    def act(self, stage: Stage, master: Master) -> None:
        """Play it."""
        numbers: list[int] = []

        def listen() -> None:
            with self.node("listener", master) as node:
                node.subscribe("/t", UInt64, lambda message: numbers.append(message.data))
                stage.until(lambda: len(numbers) == MESSAGES)

        def talk() -> None:
            with self.node("talker", master) as node:
                publisher = node.advertise("/t", UInt64, queue_size=0)
                assert publisher.wait_for_subscribers(timeout=60)
                for number in range(MESSAGES):
                    publisher.publish(number)

        stage.together(listen, talk)
        master.stop()
        assert numbers == list(range(MESSAGES)), f"lost: {numbers}"


class MeetingOverTcp(Meeting):
    """The same over connections."""

    limits = (
        *Nodes.limits,
        ("pyros1.node.subscribing.connector", "find_local_context", lambda _: None),
        ("pyros1.node.same_host", "is_local_enabled", lambda _: False),
    )


class Changing(Nodes):
    """Two threads of a node advertise, subscribe and give up topics; the master then knows what the node has."""

    def act(self, stage: Stage, master: Master) -> None:
        """Play it."""
        with self.node("node", master) as node:

            def change() -> None:
                for _ in range(2):
                    publisher = node.advertise("/a", UInt64)
                    subscriber = node.subscribe("/a", UInt64, lambda _: None)
                    publisher.publish(1)
                    publisher.unregister()
                    subscriber.unregister()

            def stay() -> None:
                node.advertise("/a", UInt64).publish(2)
                node.subscribe("/b", UInt64, lambda _: None)
                node.advertise("/b", UInt64).unregister()

            stage.together(change, stay)
            publishers, subscribers, _ = node.master.get_system_state()
            assert publishers == [["/a", ["/node"]]], publishers
            assert subscribers == [["/b", ["/node"]]], subscribers
        master.stop()


class Succeeding(Nodes):
    """A node takes the name of another one, which is at work: that one ends, and the new one is heard."""

    limits = MeetingOverTcp.limits

    def act(self, stage: Stage, master: Master) -> None:
        """Play it."""
        numbers: list[int] = []
        begun: list[bool] = []

        def first() -> None:
            with self.node("talker", master) as node:
                try:
                    publisher = node.advertise("/t", UInt64, queue_size=0)
                    begun.append(True)
                    number = 0
                    while node.ok():
                        publisher.publish(number)
                        number += 1
                        node.sleep(0.3)
                except NodeShutdownError:
                    pass

        def second() -> None:
            stage.until(lambda: begun)
            with self.node("talker", master) as node:
                publisher = node.advertise("/t", UInt64, queue_size=0)
                assert publisher.wait_for_subscribers(timeout=60)
                for number in range(MESSAGES):
                    publisher.publish(1000 + number)

        with self.node("listener", master) as node:
            node.subscribe("/t", UInt64, lambda message: numbers.append(message.data))
            threads = stage.spawn(first, second)
            stage.until(lambda: numbers[-1:] == [1000 + MESSAGES - 1], 200.0)
            for thread in threads:
                thread.join()
        master.stop()
        check_orders(numbers, gaps=True)
        assert [number for number in numbers if number >= 1000] == list(range(1000, 1000 + MESSAGES))


class Restarting(Nodes):
    """The master is replaced while nodes register: they register again, and meet."""

    limits = MeetingOverTcp.limits

    def act(self, stage: Stage, master: Master) -> None:
        """Play it."""
        numbers: list[int] = []
        done: list[bool] = []
        masters = [master]

        def restart() -> None:
            port = masters[0].port
            masters[0].stop()
            masters.append(self.start_master(port))

        def listen() -> None:
            with self.node("listener", master) as node:
                node.subscribe("/t", UInt64, lambda message: numbers.append(message.data))
                stage.until(lambda: done, 200.0)

        def talk() -> None:
            with self.node("talker", master) as node:
                publisher = node.advertise("/t", UInt64, queue_size=0)
                assert publisher.wait_for_subscribers(timeout=100), "they never meet"
                for number in range(MESSAGES):
                    publisher.publish(number)
                stage.until(lambda: len(numbers) == MESSAGES and len(masters) == 2, 100.0)
                end = stage.time.monotonic() + 100.0
                while ["/t", ["/talker"]] not in node.master.get_system_state()[0]:
                    assert stage.time.monotonic() < end, "the new master does not know of it"
                    stage.time.sleep(0.5)
            done.append(True)

        stage.together(listen, talk, restart)
        masters[-1].stop()
