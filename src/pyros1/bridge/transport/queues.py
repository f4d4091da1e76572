"""Bounded queues of packets to be sent. No I/O.

Urgent packets go first. Where only the newest message counts, it replaces the waiting one, so it is sent first after a
pause.
"""

from __future__ import annotations

import math
from itertools import count

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.rules.rules import Priority

OUTBOX_BYTES = 32 << 20
"""Maximum total size in bytes of the packets waiting to be sent; a single larger one is accepted."""
OUTBOX_PACKETS = 10_000
_GRACE = 0.05
"""Seconds that a message may wait before the network counts as too slow for it, and newer messages replace it."""
_GRACE_PACKETS = 50
"""Maximum number of a publisher's messages that may wait without being replaced."""
_MAX_COUNTED_KEYS = 5_000


class _QueuedPacket:
    """A packet and the time when it was queued."""

    __slots__ = ("packet", "since")

    def __init__(self, packet: Send, since: float) -> None:
        self.packet = packet
        self.since = since


class Outbox:
    """The queues of packets to be sent.

    Attributes:
        drops: key -> reason -> how many packets were dropped.
        waiting_packets: number of waiting packets.
        waiting_bytes: their total size.
    """

    def __init__(self, max_bytes: int = OUTBOX_BYTES, max_packets: int = OUTBOX_PACKETS) -> None:
        self.drops: dict[str, dict[str, int]] = {}
        self.waiting_packets = self.waiting_bytes = 0
        self._max_bytes = max_bytes
        self._max_packets = max_packets
        self._numbers = count()
        # For each priority: packet number -> packet, in sending order.
        self._queues: dict[Priority, dict[int, _QueuedPacket]] = {priority: {} for priority in Priority}
        # Key, `replaces` and priority, which changes with a topic's type -> the waiting packets
        self._replaceable: dict[tuple[str, int, Priority], list[int]] = {}

    def __len__(self) -> int:
        return self.waiting_packets

    def put(self, packet: Send, now: float) -> None:
        """Add a packet. If there are too many, the oldest of the lowest priority are dropped.

        Args:
            packet: the packet.
            now: the current time in seconds.
        """
        queue = self._queues[packet.priority]
        if packet.replaces is not None:
            numbers = self._replaceable.setdefault((packet.key, packet.replaces, packet.priority), [])
            is_slow = bool(numbers) and now - queue[numbers[0]].since >= _GRACE
            if numbers and (is_slow or not packet.may_drop or len(numbers) >= _GRACE_PACKETS):
                for number in numbers[1:]:
                    self._drop(queue, number, DropReason.OVERTAKEN)
                del numbers[1:]
                first = queue[numbers[0]]
                self.waiting_bytes += _size(packet) - _size(first.packet)
                self._note_drop(first.packet, DropReason.OVERTAKEN)
                first.packet = packet
                return
            numbers.append(self._append(queue, packet, now))
        else:
            self._append(queue, packet, now)
        while self.waiting_bytes > self._max_bytes or self.waiting_packets > self._max_packets:
            if not self.drop_one():
                break

    def drop_one(self) -> bool:
        """Drop the oldest packet of the lowest priority, and return True; return False if only one packet is left."""
        if self.waiting_packets <= 1:
            return False
        lowest = next(waiting for waiting in reversed(self._queues.values()) if waiting)
        number = next(iter(lowest))
        self._forget_number(lowest[number].packet, number)
        self._drop(lowest, number, DropReason.QUEUE)
        return True

    def first_priority(self) -> Priority:
        """Return the priority of the next packet to send; the lowest one if none waits."""
        return next((priority for priority, queue in self._queues.items() if queue), Priority.BACKGROUND)

    def _append(self, queue: dict[int, _QueuedPacket], packet: Send, now: float) -> int:
        number = next(self._numbers)
        queue[number] = _QueuedPacket(packet, now)
        self.waiting_packets += 1
        self.waiting_bytes += _size(packet)
        return number

    def _remove(self, queue: dict[int, _QueuedPacket], number: int) -> Send:
        packet = queue.pop(number).packet
        self.waiting_packets -= 1
        self.waiting_bytes -= _size(packet)
        return packet

    def _drop(self, queue: dict[int, _QueuedPacket], number: int, reason: str) -> None:
        self._note_drop(self._remove(queue, number), reason)

    def _forget_number(self, packet: Send, number: int) -> None:
        """Record that a packet can no longer be replaced."""
        if packet.replaces is not None:
            slot = (packet.key, packet.replaces, packet.priority)
            numbers = self._replaceable[slot]
            numbers.remove(number)
            if not numbers:
                del self._replaceable[slot]

    def pop(self, now: float, before: float = math.inf) -> Send | None:
        """Return the next packet to send, or None if there is none. Packets that are too old are dropped.

        Args:
            now: the current time in seconds.
            before: packets queued at this time or later must wait, except urgent ones.
        """
        for priority, queue in self._queues.items():
            while queue:
                number = next(iter(queue))
                if priority is not Priority.URGENT and queue[number].since >= before:
                    break
                self._forget_number(queue[number].packet, number)
                packet = self._remove(queue, number)
                if packet.expires is None or packet.expires >= now:
                    return packet
                self._note_drop(packet, DropReason.OLD)
        return None

    def _note_drop(self, packet: Send, reason: str) -> None:
        if packet.key in self.drops or len(self.drops) < _MAX_COUNTED_KEYS:
            reasons = self.drops.setdefault(packet.key, {})
            reasons[reason] = reasons.get(reason, 0) + 1


def _size(packet: Send) -> int:
    return len(packet.head) + len(packet.body)
