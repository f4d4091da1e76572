"""Delivers another site's messages to local topics. No I/O."""

from __future__ import annotations

from collections.abc import Iterable

from pyros1.bridge.exchange.actions import Action, Publish, Source
from pyros1.bridge.exchange.clock_offset import ClockOffset
from pyros1.bridge.exchange.incoming import IncomingTopic
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.exchange.outputs import Feed, Outputs
from pyros1.bridge.exchange.streams import Delivery
from pyros1.bridge.protocol.packets import Flag, MessageHead
from pyros1.ground.errors import MessageError

_EARLY_TOLERANCE = 0.05
"""Seconds by which a message may be older than the request for its topic, since ages are upper bounds."""


def deliver(
    feed: Feed,
    incoming: IncomingTopic,
    deliveries: Iterable[Delivery],
    clock: ClockOffset,
    outputs: Outputs,
    now: float,
) -> list[Action]:
    """Return the actions for messages of a topic, and count them.

    Args:
        feed: the site and the topic.
        incoming: the topic.
        deliveries: the messages, and notices that publishers are gone.
        clock: the site's clock.
        outputs: the topics published here.
        now: the current time.
    """
    actions: list[Action] = []
    local = incoming.settings.local
    for head, body in deliveries:
        source = Source(*feed, head.publisher)
        if body is None or head.flags & Flag.LEFT:  # it may come even if this site does not count the topic as latched
            actions += outputs.forget(local, source)
            continue
        is_latched = bool(head.flags & Flag.LATCHED) and incoming.offered.latched
        age = clock.age(head.received_at, now)
        reason = _reason_to_drop(incoming, head, len(body), is_latched, age, now)
        if reason is None:
            try:
                body = incoming.prefixer.change(body)  # noqa: PLW2901 - with prefixes, if a rule asks for them
            except MessageError:
                reason = DropReason.DAMAGED
        if reason is not None:
            incoming.flow.drop(reason)
            if is_latched:  # later subscribers must not get the source's earlier message as the current one
                actions += outputs.forget(local, source)
            continue
        incoming.flow.count(len(body))
        expires = None if is_latched or age is None else now + incoming.settings.age - age
        is_kept = is_latched and outputs.is_latched(local)
        if is_kept:
            outputs.hold(local, source)
        actions.append(Publish(local, source, body, is_kept, expires))
    return actions


def _reason_to_drop(
    incoming: IncomingTopic, head: MessageHead, size: int, is_latched: bool, age: float | None, now: float
) -> str | None:
    settings = incoming.settings
    if size > settings.max_size:
        return DropReason.SIZE
    if is_latched:
        return None
    if age is None or age > settings.age:
        return DropReason.OLD
    # An earlier run of this site may have delivered messages sent before this run wanted the topic.
    if age > now - incoming.wanted_since + _EARLY_TOLERANCE:
        return DropReason.EARLY
    return incoming.reason_to_limit(head.publisher, now) if settings.rate else None
