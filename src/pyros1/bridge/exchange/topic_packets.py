"""The packets that carry a topic's messages. No I/O."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.exchange.outgoing import NumberedMessage, OutgoingTopic
from pyros1.bridge.protocol.key_expressions import direct_topic_key, peer_key, topic_key
from pyros1.bridge.protocol.packets import (
    Definition,
    Flag,
    Kind,
    MessageHead,
    ResendRefusal,
    ResendRequest,
    encode_definition,
    encode_head,
    encode_latched_list,
    encode_message_head,
    encode_resend_refusal,
)


class TopicPackets:
    """Makes the packets that carry a topic's messages.

    Args:
        epoch: this site's epoch.

    Attributes:
        epochs: the epochs of the other known sites.
    """

    def __init__(self, epoch: int) -> None:
        self.epochs: Mapping[str, int] = {}
        self._epoch = epoch

    def of_message(self, topic: OutgoingTopic, message: NumberedMessage, separate: Collection[str]) -> list[Send]:
        """Return the packets for a message: one for all sites that want it, and those for sites that get their own."""
        head = message.head
        if not separate:
            return [_of_message(topic, message, topic_key(topic.topic), head)]
        packets = [
            _of_message(
                topic, message, direct_topic_key(peer, topic.topic), head._replace(to_epoch=self.epochs.get(peer, 0))
            )
            for peer in sorted(separate)
        ]
        if len(separate) < len(topic.requests):
            packets.append(_of_message(topic, message, topic_key(topic.topic), head))
        return packets

    def latched_list(self, topic: OutgoingTopic, peer: str) -> list[Send]:
        """Return the packets for the latched messages that a topic holds."""
        messages, latched_list = topic.latched_list()
        packets = [self._of_old_message(topic, message, peer) for message in messages]
        # The list has the messages' priority, so that it arrives after them.
        return [
            *packets,
            Send(
                peer_key(peer),
                self._head(Kind.LATCHED_LIST, peer),
                encode_latched_list(latched_list),
                topic.settings.priority,
            ),
        ]

    def resend(self, topic: OutgoingTopic, peer: str, missed: ResendRequest) -> list[Send]:
        """Return the packets that resend messages a site has missed, or tell which ones are no longer kept."""
        if topic.offered.latched:
            return self.latched_list(topic, peer)
        messages, first_kept = topic.resend(missed)
        packets: list[Send] = []
        if missed.first < first_kept:
            body = encode_resend_refusal(ResendRefusal(missed.topic, first_kept))
            packets.append(Send(peer_key(peer), self._head(Kind.RESEND_REFUSAL, peer), body, topic.settings.priority))
        return packets + [self._of_old_message(topic, message, peer) for message in messages]

    def _of_old_message(self, topic: OutgoingTopic, message: NumberedMessage, peer: str) -> Send:
        head = message.head._replace(to_epoch=self.epochs.get(peer, 0))
        packet = _of_message(topic, message, direct_topic_key(peer, topic.topic), head)
        # A message that is already waiting to be resent is not queued twice.
        return packet._replace(replaces=head.number, may_drop=False)

    def definition(self, peer: str, definition: Definition) -> Send:
        """Return the packet for a definition."""
        return Send(peer_key(peer), self._head(Kind.DEFINITION, peer), encode_definition(definition))

    def _head(self, kind: Kind, peer: str) -> bytes:
        return encode_head(kind, self._epoch, self.epochs.get(peer, 0))


def _of_message(topic: OutgoingTopic, message: NumberedMessage, key: str, head: MessageHead) -> Send:
    never_expires = bool(head.flags & (Flag.LATCHED | Flag.LEFT))
    is_lossless = topic.is_lossless
    return Send(
        key,
        encode_message_head(head),
        message.body,
        topic.settings.priority,
        None if is_lossless else head.publisher,
        not is_lossless,
        None if never_expires else head.received_at + topic.settings.age,
    )
