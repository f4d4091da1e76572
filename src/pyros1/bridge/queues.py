"""What waits between a site and its link, bounded on both ways. No I/O.

- `Outbox`: packets that wait until the network takes them. Urgent ones go first; where only the newest message counts,
  a newer one takes the place of the one that waits, so after a pause the newest goes first.
- `Inbox`: packets that wait until the site deals with them. Few bytes are allowed for messages, so that another site
  that floods this one costs only its own messages.
"""

from __future__ import annotations

from collections import deque
from itertools import count

from pyros1.bridge.actions import Send
from pyros1.bridge.keys import Key
from pyros1.bridge.outgoing import Drop
from pyros1.bridge.rules import Priority

OUTBOX_BYTES = 32 << 20
"""Maximum total size in bytes of the packets that wait to be sent; at least one may."""
OUTBOX_PACKETS = 10_000
INBOX_BYTES = 64 << 20
"""Maximum total size in bytes of the messages that have come and wait; at least one may."""
INBOX_PACKETS = 10_000
"""Maximum number of them, and of other packets."""
_MAX_COUNTED_KEYS = 5_000

Received = tuple[Key, bytes, bytes]
"""A packet that has come: key, head and body."""


class Outbox:
    """Packets that wait to be sent.

    Attributes:
        drops: key -> reason -> how many packets were dropped.
        waiting_bytes: total size of the waiting packets.
    """

    def __init__(self, max_bytes: int = OUTBOX_BYTES, max_packets: int = OUTBOX_PACKETS) -> None:
        self.drops: dict[str, dict[str, int]] = {}
        self.waiting_bytes = 0
        self._max_bytes = max_bytes
        self._max_packets = max_packets
        self._numbers = count()
        # For each priority, in order: what a packet is replaced by -> the packet.
        self._queues: dict[Priority, dict[tuple[str, int | str], Send]] = {priority: {} for priority in Priority}

    def __len__(self) -> int:
        return sum(map(len, self._queues.values()))

    def put(self, packet: Send) -> None:
        """Add a packet. If there are too many, the oldest of the lowest priority are dropped."""
        queue = self._queues[packet.priority]
        slot: tuple[str, int | str] = (packet.key, f"#{next(self._numbers)}")
        if packet.replaces is not None:
            slot = (packet.key, packet.replaces)
            if (old := queue.get(slot)) is not None:
                self.waiting_bytes -= _size(old)
                self._count(old, Drop.OVERTAKEN)
        queue[slot] = packet
        self.waiting_bytes += _size(packet)
        while len(self) > 1 and (self.waiting_bytes > self._max_bytes or len(self) > self._max_packets):
            lowest = next(waiting for waiting in reversed(self._queues.values()) if waiting)
            dropped = lowest.pop(next(iter(lowest)))
            self.waiting_bytes -= _size(dropped)
            self._count(dropped, Drop.QUEUE)

    def pop(self, now: float) -> Send | None:
        """Return the packet to send next, or None if none waits. Those that are too old are dropped."""
        for queue in self._queues.values():
            while queue:
                packet = queue.pop(next(iter(queue)))
                self.waiting_bytes -= _size(packet)
                if packet.expires is None or packet.expires >= now:
                    return packet
                self._count(packet, Drop.OLD)
        return None

    def _count(self, packet: Send, reason: str) -> None:
        if packet.key in self.drops or len(self.drops) < _MAX_COUNTED_KEYS:
            reasons = self.drops.setdefault(packet.key, {})
            reasons[reason] = reasons.get(reason, 0) + 1


class Inbox:
    """Packets that have come and wait.

    Attributes:
        dropped: how many packets were dropped because too many waited.
    """

    def __init__(self, max_bytes: int = INBOX_BYTES, max_packets: int = INBOX_PACKETS) -> None:
        self.dropped = 0
        self._max_bytes = max_bytes
        self._max_packets = max_packets
        self._control: deque[Received] = deque()
        self._messages: deque[Received] = deque()
        self._message_bytes = 0

    def put(self, packet: Received) -> None:
        """Add a packet. If there are too many messages, the oldest is dropped; of other packets, the new one."""
        key, head, body = packet
        if key.topic is None:
            if len(self._control) >= self._max_packets:
                self.dropped += 1
            else:
                self._control.append(packet)
            return
        self._messages.append(packet)
        self._message_bytes += len(head) + len(body)
        while len(self._messages) > 1 and (
            self._message_bytes > self._max_bytes or len(self._messages) > self._max_packets
        ):
            _, head, body = self._messages.popleft()
            self._message_bytes -= len(head) + len(body)
            self.dropped += 1

    def pop(self) -> Received | None:
        """Return the packet to deal with next, or None if none waits. Beats and lists go first."""
        if self._control:
            return self._control.popleft()
        if not self._messages:
            return None
        packet = self._messages.popleft()
        self._message_bytes -= len(packet[1]) + len(packet[2])
        return packet


def _size(packet: Send) -> int:
    return len(packet.head) + len(packet.body)
