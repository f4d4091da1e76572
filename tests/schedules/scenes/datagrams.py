"""A topic over UDP: messages of several datagrams, some lost; publishers that go on while the link comes and goes.

What arrives is whole, and each thread's in order; what arrives and what counts as dropped is no more than was sent, and
all of it if the network loses nothing. A subscriber that has gone is noticed.
"""

from __future__ import annotations

import socket
from typing import Any

from pyros1.msgs.std_msgs.msg import String
from pyros1.net.hosts import LocalAddress
from pyros1.node.context import Context
from pyros1.node.publishing.publication import Publication
from pyros1.node.publishing.udp_link import UdpLink
from pyros1.node.subscribing.hints import Hints
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.node.subscribing.subscription import Subscription
from pyros1.node.subscribing.udp_source import UdpSource
from pyros1.wire.datagram import MIN_DATAGRAM_SIZE, parse_udpros_offer, parse_udpros_response

from ..stage import Scenario, Stage
from .parts import PUBLISHING, SUBSCRIBING, THREAD, check_orders, end_context, make_context, make_publication

THREADS, MESSAGES = 2, 4
LENGTH = 30
"""Repetitions of a number in a message, which makes it three datagrams."""


def text(number: int) -> str:
    """Return the text of a message."""
    return f"{number:04} " * LENGTH


def on_the_way(stage: Stage) -> bool:
    """Return whether datagrams wait in a socket."""
    return any(sock.readable and not sock.broken for sock in stage.network.datagrams.values())


class Datagrams(Scenario):
    """The publishers send all; then the link ends."""

    modules = (
        *PUBLISHING,
        "pyros1.node.publishing.udp_link",
        *SUBSCRIBING,
        "pyros1.node.subscribing.udp_source",
        "pyros1.wire.datagram",
    )
    limits = (("pyros1.node.strand", "MAX_JOBS_PER_TURN", 2),)
    whole = True

    def play(self, stage: Stage) -> None:
        """Play it."""
        talker, context = make_context(stage, "/talker"), make_context(stage, "/listener")
        context.address = LocalAddress("localhost", "127.0.0.1", socket.AF_INET)
        publication = make_publication(talker, 0, message_class=String)
        hints = Hints(transports=("udp",), max_datagram_size=MIN_DATAGRAM_SIZE)
        subscription = Subscription(context, "/t", String, hints)
        numbers: list[int] = []

        def take(message: String) -> None:
            number = int(message.data[:4])
            assert message.data == text(number), "a message of parts of several"
            numbers.append(number)

        subscriber: Any = Subscriber(subscription, String, take, None, subscription.remove)  # type: ignore[arg-type]
        subscription.add(subscriber)
        source, link = self.connect(context, talker, publication, subscription)

        def publisher(thread: int) -> Any:
            def publish() -> None:
                for number in range(MESSAGES):
                    publication.publish(String(text(THREAD * thread + number)))

            return publish

        stage.together(lambda: self.end(publication, source), *(publisher(thread) for thread in range(THREADS)))
        while publication.links and not self.whole:
            publication.publish(String(text(THREAD * THREADS)))
            stage.time.sleep(0.01)
        stage.until(lambda: publication.strand.free and not (publication.strand.jobs or on_the_way(stage)))
        context.loop.run(source.close)
        stage.until(lambda: not subscription.delivery.waiting)
        assert len(numbers) >= source.messages - 1, (
            "messages wait that do not count: all but the one that is being taken"
        )
        stage.until(lambda: len(numbers) == source.messages)
        publication.close()
        context.loop.run(lambda: None)
        subscription.close()
        for each in (context, talker):
            end_context(each)
        dropped, sent = subscription.delivery.dropped, link.messages - link.dropped
        assert len(numbers) + dropped <= sent, f"{numbers}, {dropped} dropped of {sent}"
        if self.whole and not stage.network.lost:
            assert len(numbers) == THREADS * MESSAGES == sent
            assert not dropped
        check_orders(numbers, gaps=True)

    def end(self, publication: Publication, source: UdpSource) -> None:
        """End one side, while others publish."""

    def connect(
        self, context: Context, talker: Context, publication: Publication, subscription: Subscription
    ) -> tuple[UdpSource, UdpLink]:
        """Link a subscription, as a call of `requestTopic` does."""
        source = context.loop.run(subscription.offer_datagrams, talker.uri)
        offer = parse_udpros_offer(source.offer())
        assert offer is not None
        link: UdpLink = talker.loop.run(publication.accept_datagrams, *offer)
        answer = parse_udpros_response(link.topic_response("localhost"))
        assert answer is not None

        def begin() -> None:
            source.begin(*answer)
            subscription.add_inbox_link(source)

        context.loop.run(begin)
        return source, link


class LeavingDatagrams(Datagrams):
    """The subscriber leaves while others publish."""

    whole = False

    def end(self, publication: Publication, source: UdpSource) -> None:
        """End the subscriber's."""
        source.close()


class EndingDatagrams(Datagrams):
    """The publisher ends while others publish."""

    whole = False

    def end(self, publication: Publication, source: UdpSource) -> None:
        """End the publisher's."""
        publication.close()
