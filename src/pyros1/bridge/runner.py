"""A running bridge: a node on the site's master, a link to other sites, and the site's state machine between them.

Several threads use the state machine. A lock guards it, and is held until the resulting actions, none of which blocks,
have been carried out or queued in order. These are the threads:

- the node's threads pass messages to the state machine, and its packets to the sender;
- the link's threads, or the packet worker's thread if packets are waiting, handle packets and publish their messages;
  the packet worker also ticks (`pyros1.bridge.packet_worker`);
- the master thread queries the master, subscribes and advertises, all of which may block;
- the sender has two threads, which may block on the network (`pyros1.bridge.transport.sender`);
- two threads convert messages, if rules say so (`pyros1.bridge.conversion_pool`).

So neither a slow master nor a slow network stops the node's loop, its callbacks, or the link's own threads.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Collection, Iterable
from functools import partial

from pyros1.bridge.bridge_publishers import BRIDGE_FIELD, BridgePublishers
from pyros1.bridge.clock import steady_now
from pyros1.bridge.conversion_pool import ConversionPool, PendingMessage, Source
from pyros1.bridge.conversions.conversion import Conversion
from pyros1.bridge.conversions.converters import with_conversions
from pyros1.bridge.deferred import Change, DeferredActions
from pyros1.bridge.exchange.actions import (
    Action,
    Advertise,
    CallService,
    Forget,
    Listen,
    Log,
    Probe,
    ProbeReply,
    Provide,
    Publish,
    RepresentNode,
    RestartConversion,
    Return,
    Send,
    SetOrigins,
    StopProviding,
    Subscribe,
    Withdraw,
)
from pyros1.bridge.exchange.outgoing import ReceivedMessage
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.exchange.token_bucket import TokenBucket
from pyros1.bridge.link_report import LinkReport
from pyros1.bridge.local_graph import LocalGraph
from pyros1.bridge.packet_worker import PacketWorker
from pyros1.bridge.publisher_watch import PublisherWatch
from pyros1.bridge.rates import Rates
from pyros1.bridge.rules.rules import Priority, Rules
from pyros1.bridge.service_ends import ServiceEnds
from pyros1.bridge.stand_ins import StandIns
from pyros1.bridge.status import flow_counts, status_json
from pyros1.bridge.transport.inbox import Inbox, Received
from pyros1.bridge.transport.link import Link, Receive
from pyros1.bridge.transport.sender import Sender
from pyros1.doctor.bridge_status import STATUS_SERVICE
from pyros1.graph import Graph
from pyros1.ground.errors import Error
from pyros1.ground.names import FullName
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.node.log.levels import INFO, WARN
from pyros1.node.subscribing.subscriber import Subscriber

_POLL_PERIOD = 1.0
"""Seconds between polls of the master."""
_DEMAND_PERIOD = 0.2
"""Seconds between checks of which published topics have subscribers."""
_QUEUE_SIZE = 1000
"""Maximum number of queued messages of a publisher. The bridge only passes them on, so the queue is usually empty."""
_JOIN_TIME = 3.0
_LOG_RATE = 0.5
_LOG_BURST = 50
"""Maximum number of messages about other sites, per second and in one burst, that are logged even if they are
repetitions.
"""
MakeLink = Callable[[Receive], Link]


class Bridge:
    """A running bridge. It ends when its node shuts down, or by `close`.

    Args:
        node: the bridge's node; it must run callbacks inline.
        rules: the site's rules.
        make_link: returns the link, given the function that receives its packets.
        allowed: the certificate names that have any permissions; empty for all.

    Raises:
        LinkError: the link cannot start.
        NodeError: the node cannot provide the bridge's service.
    """

    def __init__(self, node: Node, rules: Rules, make_link: MakeLink, allowed: Collection[str] = ()) -> None:
        self._node = node
        self._rules = rules
        self._lock = threading.RLock()  # the sender may request probes in the thread that gives it a packet
        self._site = Site(rules, int.from_bytes(os.urandom(8), "little") | 1, steady_now())
        self._bridge_publishers = BridgePublishers(node, rules.site)
        self._graph = LocalGraph(Graph(node.master), self._may_be_sent)
        self._services = ServiceEnds(node, rules, self._site, self._do_next)
        self._watch = PublisherWatch(node, rules.loss_delay, self._on_watched)
        self._stand_ins = StandIns(node)
        self._subscribers: dict[tuple[str, Conversion | None], Subscriber[AnyMsg]] = {}
        self._conversion_pool = ConversionPool(self, node.log.internal_error)
        self._unconvertible: dict[str, str] = {}
        self._rates = Rates()
        self._deferred = DeferredActions()
        self._next_poll = 0.0
        self._subscribed: frozenset[str] = frozenset()
        self._is_closing = False
        self._problems: dict[str, int] = {}
        self._close_lock = threading.Lock()
        self._is_closed = False
        self._worker = PacketWorker(self._lock, steady_now, self._on_packet, self._tick, self._node.log.internal_error)
        self._link = make_link(self._worker.receive)
        self._link_report = LinkReport(self._link, allowed)
        self._log_bucket = TokenBucket(_LOG_RATE, _LOG_BURST)
        self._sender = Sender(self._link, steady_now, self._on_link_error, self._make_probes, self._on_slow)
        self._master_thread = threading.Thread(target=self._run_master_thread, name="bridge: master", daemon=True)
        with self._lock:
            self._act(self._site.start())
        self._worker.start()
        self._master_thread.start()
        node.on_shutdown(self.close)  # may call it at once, so the threads must exist
        try:
            node.advertise_service(f"~{STATUS_SERVICE}", "std_srvs/Trigger", lambda _: (True, self.status()))
            self._services.start()
        except BaseException:
            self.close()
            raise

    @property
    def inbox(self) -> Inbox:
        """The queue of packets from other sites."""
        return self._worker.inbox

    # The link's side --------------------------------------------------------------------------------------------------

    def _on_packet(self, packet: Received, now: float) -> None:
        """Let the state machine handle a packet. Called with the lock held."""
        self._act(self._site.on_packet(*packet, now))

    def _tick(self, now: float) -> None:
        """Call the state machine's timer. Called with the lock held."""
        self._act(self._site.tick(now))
        self.inbox.known = self._site.known_sites()
        if self._rates.is_due(now):
            self._rates.add(flow_counts(self._site), now)

    def _do_next(self, step: Callable[[float], Iterable[Action]]) -> None:
        """Call a function of the state machine with the current time, and carry out the actions that it returns."""
        with self._lock:
            self._act(step(steady_now()))

    def _act(self, actions: Iterable[Action]) -> None:
        """Carry out the state machine's actions, or queue them for the master thread if they may block. Called with the
        lock held.
        """
        for action in actions:
            match action:
                case Send():
                    self._sender.put(action)
                case Publish():
                    self._publish(action)
                case Forget():
                    if not self._deferred.hold(action):
                        self._bridge_publishers.forget(action)
                case RepresentNode():
                    self._stand_ins.note(action)
                    self._deferred.wake()
                case Listen(site, key, on):
                    self._sender.listen(site, key, on)
                case ProbeReply(site, number):
                    self._sender.on_probe_reply(site, number)
                case Provide() | StopProviding() | CallService() | Return():
                    self._act(self._services.act(action, steady_now()))
                case Log():
                    self._log(action)
                case RestartConversion():
                    self._conversion_pool.restart((action.local, action.conversion))
                case Subscribe() | SetOrigins() | Advertise() | Withdraw():
                    self._deferred.put(action)

    def _log(self, log: Log) -> None:
        """Log a message. Once too many have been logged, repetitions are limited as for other messages about peers."""
        if not self._log_bucket.take(steady_now()):
            self._node.log.peer_event(WARN if log.is_warning else INFO, "%s", one_line(log.text))
        elif log.is_warning:
            self._node.log.warn("%s", one_line(log.text))
        else:
            self._node.log.info("%s", one_line(log.text))

    def _publish(self, action: Publish) -> None:
        if self._deferred.hold(action):
            return
        try:
            if not self._bridge_publishers.publish(action):
                self._count("messages of topics that could not be published")
        except Error as error:
            if self._node.ok():
                self._node.log.peer_event(WARN, "cannot publish on %s: %s", one_line(action.local), error)

    def _make_probes(self, receiver: str, number: int, priority: Priority) -> list[Probe]:
        """Return probes to send. Called in the sender's threads, or in a thread that gives it a packet."""
        with self._lock:
            return self._site.probes(receiver, number, priority)

    def _on_slow(self, site: str) -> None:
        """Record that a site holds up others. Called in the sender's threads."""
        self._do_next(lambda now: self._site.on_slow(site, now))

    def _on_link_error(self, error: Exception) -> None:
        self._count("packets that could not be sent")
        if not self._is_closing:
            self._node.log.peer_event(WARN, "cannot send to other sites: %s", one_line(error, 200))

    def _count(self, problem: str) -> None:
        self._problems[problem] = self._problems.get(problem, 0) + 1

    # The master's side ------------------------------------------------------------------------------------------------

    def _run_master_thread(self) -> None:
        while not self._is_closing:
            try:
                self._look_after_master()
            except Exception as error:  # noqa: BLE001 - a bug must not end the bridge silently
                self._node.log.internal_error(error)

    def _look_after_master(self) -> None:
        timeout = _DEMAND_PERIOD
        while not self._is_closing and (changes := self._deferred.pop(timeout)):
            self._change(changes)
            timeout = 0.0
        self._services.update()
        self._stand_ins.update()
        if time.monotonic() >= self._next_poll and not self._is_closing:
            self._next_poll = time.monotonic() + _POLL_PERIOD  # set first: a watch may request an earlier poll
            self._poll()
            if self._graph.is_behind:
                self._next_poll = 0.0
            self._deferred.retry()
            for log in self._link_report.update(steady_now()):
                self._log(log)
        subscribed = self._bridge_publishers.subscribed_topics(self._graph.bridges)
        if subscribed != self._subscribed:
            self._subscribed = subscribed
            with self._lock:
                self._act(self._site.set_subscribed(subscribed, steady_now()))

    def _change(self, changes: list[Change]) -> None:
        """Carry out actions that may block while the master responds."""
        for index, action in enumerate(changes):
            try:
                self._do(action)
            except Error as error:
                self._deferred.fail(changes[index:])
                if self._node.ok():
                    self._node.log.peer_event(WARN, "cannot bridge a topic: %s", error)
                return
        if self._deferred.finish_if_nothing_waits():
            return  # skip the lock, on which others wait: there may be thousands of topics
        with self._lock:  # publish the waiting messages before later ones
            self._act(self._deferred.finish())

    def _do(self, action: Change) -> None:
        match action:
            case Advertise():
                self._bridge_publishers.advertise(action)
            case Withdraw(local):
                self._bridge_publishers.withdraw(local)
            case SetOrigins(local, origins):
                self._bridge_publishers.set_origins(local, origins)
            case Subscribe():
                self._subscribe(action)

    def _subscribe(self, action: Subscribe) -> None:
        local, on, conversion = action
        if on:
            if conversion is not None:
                self._conversion_pool.start((local, conversion))
            callback = partial(self._on_message, local, conversion)
            subscriber = self._node.subscribe(FullName(local), AnyMsg, callback, queue_size=_QUEUE_SIZE)
            self._subscribers[local, conversion] = subscriber
            return
        old = self._subscribers.pop((local, conversion), None)
        if old is not None:
            old.unregister()
        if conversion is not None:
            self._conversion_pool.stop((local, conversion))

    def _poll(self) -> None:
        asked_at = steady_now()
        self._graph.lost = self._watch.lost
        try:
            topics, self._unconvertible = with_conversions(self._graph.topics(), self._rules)
            self._services.poll(self._graph.state)
        except Error as error:
            if self._node.ok():
                self._node.log.peer_event(WARN, "cannot ask the master for topics: %s", str(error).replace("\n", " "))
            return
        with self._lock:
            self._site.topic_sender.set_registered(self._graph.state.publishers, asked_at)
            self._act(self._site.set_used_topics(self._graph.used, steady_now()))
            self._act(self._site.set_topics(topics, asked_at, steady_now()))
            wanted = [
                name for topic, local, _ in self._site.sent_topics() if topic.requests for name in local.publishers
            ]
        if self._node.ok():
            self._watch.update(wanted, self._graph.publishers)

    def _on_watched(self) -> None:
        """Tell other sites which nodes respond. Called in threads of the node."""
        with self._lock:
            self._act(self._site.set_responding(self._watch.responding, steady_now()))
        self._next_poll = 0.0
        self._deferred.wake()

    def _may_be_sent(self, topic: str) -> bool:
        with self._lock:
            others = [site.name for site in self._site.sites()]
        return bool(self._rules.outgoing(topic, others))

    def _on_message(self, local: str, conversion: Conversion | None, message: AnyMsg) -> None:
        """Pass a message to the state machine. Called in the node's threads."""
        header = message._connection_header or {}
        publisher, md5sum = header.get("callerid", ""), header.get("md5sum", "")
        is_bridged = BRIDGE_FIELD in header or publisher in self._graph.bridges or publisher == self._node.name
        self._graph.check_type(publisher, local, md5sum)
        is_latched = header.get("latching") == "1"
        uri = self._publisher_uri(local, conversion, publisher) if is_latched else ""
        received = ReceivedMessage(publisher, md5sum, is_latched, bytes(message._buff), uri)
        now = steady_now()
        if conversion is not None:
            self._conversion_pool.put(
                (local, conversion), PendingMessage(received, header.get("type", ""), is_bridged, now)
            )
            return
        with self._lock:
            self._act(self._site.on_message(local, received, is_bridged, now))

    def _publisher_uri(self, local: str, conversion: Conversion | None, publisher: str) -> str:
        """Return the URI of the node that publishes a topic; empty if the bridge has only just subscribed."""
        subscriber = self._subscribers.get((local, conversion))
        links = () if subscriber is None else subscriber.links
        return next((link.uri for link in links if link.header.get("callerid") == publisher), "")

    # Conversions; called by the converting threads -------------------------------------------------------------------

    def would_send(self, source: Source, pending: PendingMessage) -> bool:
        """See `pyros1.bridge.conversion_pool.ConversionSink`."""
        with self._lock:
            return self._site.topic_sender.would_send(*source, pending.received, pending.is_bridged, pending.at)

    def send(self, source: Source, pending: PendingMessage) -> None:
        """See `pyros1.bridge.conversion_pool.ConversionSink`."""
        local, conversion = source
        with self._lock:
            self._act(self._site.on_message(local, pending.received, pending.is_bridged, pending.at, conversion))

    def drop(self, source: Source, publisher: str, reason: str) -> None:
        """See `pyros1.bridge.conversion_pool.ConversionSink`."""
        self._do_next(lambda now: self._site.topic_sender.drop(*source, publisher, reason, now))

    # Shutdown ---------------------------------------------------------------------------------------------------------

    def status(self) -> str:
        """Return the bridge's status as JSON, see `pyros1.bridge.status`."""
        problems = {
            **self._graph.problems,
            **self._services.problems,
            **self._unconvertible,
            **self._conversion_pool.problems,
        }
        with self._lock:
            return status_json(
                self._site, self._link, self._sender, self.inbox, self._rates, problems, self._all_problems()
            )

    def _all_problems(self) -> dict[str, int]:
        early = self._deferred.dropped
        return self._problems | ({"messages that came before their topic was advertised": early} if early else {})

    def close(self) -> None:
        """Tell other sites that this one leaves, and end all threads. May be called repeatedly."""
        with self._close_lock:
            if self._is_closed:
                return
            self._is_closed = True
        with self._lock:
            self._act(self._site.leave())
        self._is_closing = True
        self._deferred.wake()
        self._worker.close()
        self._master_thread.join(_JOIN_TIME)
        self._services.close()
        self._conversion_pool.close()
        self._sender.close()
        self._link.close()
        self._stand_ins.close()
        if self._node.ok():  # a node that is shutting down unregisters everything itself
            for subscriber in self._subscribers.values():
                subscriber.unregister()
            self._watch.close()
            self._bridge_publishers.close()
