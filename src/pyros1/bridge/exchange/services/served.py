"""The services of this site that other sites may call, and the calls to them: each call runs at most once. No I/O.

A call is new if its number is higher than the last one in its slot; a repeated call gets the same reply again. A reply
is resent until the other site acknowledges it, the call expires, or the other site is forgotten. Slots are remembered
for the other site's whole run, even while it is lost or forgotten.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from pyros1.bridge.exchange.actions import Action, CallService
from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.exchange.services.call_packets import (
    SMALL,
    CallCounts,
    encode_error,
    max_transit_time,
    repeat_period,
    send,
)
from pyros1.bridge.names import SharedName, is_topic_name
from pyros1.bridge.protocol.calls import MAX_CALL_SIZE, MAX_SLOTS, CallHead, CallId, OfferedService, Status
from pyros1.bridge.protocol.packets import Kind
from pyros1.bridge.rules.rules import Rule, Rules
from pyros1.bridge.rules.services import PARAMETERS, match_served
from pyros1.bridge.rules.site_access import may_call

MAX_RUNNING = 64
"""Maximum number of calls from all other sites that run at the same time."""
MAX_RUNNING_BYTES = 128 << 20
"""Maximum total size in bytes of the requests of all running calls."""
MAX_REPLY_BYTES = 32 << 20
"""Maximum total size in bytes of the replies that a site has not acknowledged."""
MAX_ALL_REPLY_BYTES = 128 << 20
"""Maximum total size in bytes of the replies that have not been acknowledged by any site."""
MAX_SITES = 1_000
"""Maximum number of sites whose slots are remembered."""
_ANSWER_PERIOD = 0.5
"""Minimum seconds between replies to repetitions of a call."""
_PARAMETERS_TYPE = ("pyros1_bridge/Parameters", "0" * 32, "pyros1_bridge/Words", "pyros1_bridge/Value")


class LocalService(NamedTuple):
    """A service of this site's master that a node other than a bridge provides.

    Attributes:
        name: its full name.
        type, md5sum, request, response: its type, its md5 sum, and the types of its requests and responses.
        node: the node.
    """

    name: str
    type: str
    md5sum: str
    request: str
    response: str
    node: str


class ServedService(NamedTuple):
    """A service that other sites may call, with its name on this site's master, its rule and its counters."""

    offered: OfferedService
    local: str
    rule: Rule | None
    counts: CallCounts


class _Slot:
    """A caller's slot, with the last call in it."""

    def __init__(self, number: int, service: SharedName, expires: float) -> None:
        self.number = number
        self.service = service
        self.expires = expires
        self.reply: tuple[Status, bytes] | None = None
        self.is_over = False  # whether nobody waits for the reply any longer
        self.repeats = 0
        self.sent_at = float("-inf")

    def end(self) -> None:
        """Discard the reply, since nobody waits for it any longer."""
        self.reply, self.is_over = None, True


class Caller:
    """The calls from a run of another site."""

    def __init__(self, peer: str, epoch: int) -> None:
        self.peer = peer
        self.epoch = epoch
        self.slots: dict[int, _Slot] = {}

    @property
    def reply_bytes(self) -> int:
        """The total size of the replies that have not been acknowledged."""
        return sum(len(slot.reply[1]) for slot in self.slots.values() if slot.reply)


class ServedServices:
    """The services that a site serves.

    Args:
        rules: the site's rules.
        epoch: the site's epoch.
        peers: the other sites; shared with the caller, which updates it.

    Attributes:
        callers: the calls from each other site.
    """

    def __init__(self, rules: Rules, epoch: int, peers: Mapping[str, Peer]) -> None:
        self._rules = rules
        self._epoch = epoch
        self._peers = peers
        self._served: dict[SharedName, ServedService] = {}
        self.callers: dict[str, Caller] = {}
        self._running: dict[CallId, int] = {}  # call -> size of its request
        self.set_services(())

    # Current state ----------------------------------------------------------------------------------------------------

    def set_services(self, services: Iterable[LocalService]) -> None:
        """Record the services of this site's master, except those of bridges."""
        old, self._served = self._served, {}
        if self._rules.services.params:
            shared = SharedName(self._rules.site, PARAMETERS)
            self._add(old, ServedService(OfferedService(shared, *_PARAMETERS_TYPE), PARAMETERS, None, CallCounts()))
        for service in sorted(services):
            outgoing = match_served(self._rules, service.name) if is_topic_name(service.name) else None
            if outgoing is not None and outgoing.shared not in self._served:
                offered = OfferedService(outgoing.shared, *service[1:5])
                self._add(old, ServedService(offered, service.name, outgoing.rule, CallCounts()))

    def _add(self, old: Mapping[SharedName, ServedService], service: ServedService) -> None:
        shared = service.offered.service
        self._served[shared] = service._replace(counts=old[shared].counts) if shared in old else service

    def offers(self, peer: str) -> list[OfferedService]:
        """Return the services that another site may call."""
        return [service.offered for service in self._served.values() if self._is_for(service, peer)]

    def _is_for(self, service: ServedService, peer: str) -> bool:
        return (
            self._rules.talks_to(peer)
            and (service.rule is None or service.rule.applies_to(peer))
            and may_call(self._rules.access, peer, service.offered.service)
        )

    def services(self) -> list[ServedService]:
        """Return the services that are served, for the status."""
        return [*self._served.values()]

    # Calls ------------------------------------------------------------------------------------------------------------

    def on_call(self, peer: str, name: SharedName, head: CallHead, body: bytes, now: float) -> list[Action]:
        """Handle a call from another site's current run, and return the resulting actions."""
        caller = self._caller(peer)
        slot = caller.slots.get(head.slot)
        if slot is not None and head.number <= slot.number:
            return self._on_repetition(caller, head, slot, now) if head.number == slot.number else []
        age = self._peers[peer].clock.age(head.sent_at, now)
        if age is None or age > min(head.left, max_transit_time(len(body))):
            return []  # the caller has given up, or will repeat the call
        slot = caller.slots[head.slot] = _Slot(head.number, name, now + head.left - age)
        service = self._served.get(name)
        if service is not None and self._is_for(service, peer):
            service.counts.calls += 1
        if problem := self._problem(peer, service, body):
            return self._reply(caller, head.slot, slot, (Status.REFUSED, encode_error(problem)), now)
        assert service is not None  # if it is None, `_problem` returns a reason
        call = CallId(peer, caller.epoch, head.slot, head.number)
        self._running[call] = len(body)
        timeout = slot.expires - now
        if service.rule is not None and service.rule.timeout is not None:
            timeout = min(timeout, service.rule.timeout)
        actions: list[Action] = [CallService(call, service.local, body, timeout)]
        if len(body) > SMALL:  # small ones may be resent: the reply usually arrives first
            actions += self._send(Kind.CALL_SEEN, caller, call.slot, slot, now)
        return actions

    def _caller(self, peer: str) -> Caller:
        epoch = self._peers[peer].epoch
        caller = self.callers.get(peer)
        if caller is None or caller.epoch != epoch:
            self.callers.pop(peer, None)
            if len(self.callers) >= MAX_SITES:
                away = next((name for name in self.callers if name not in self._peers), next(iter(self.callers)))
                del self.callers[away]
            caller = self.callers[peer] = Caller(peer, epoch)
        return caller

    def _on_repetition(self, caller: Caller, head: CallHead, slot: _Slot, now: float) -> list[Action]:
        if slot.reply is None:
            return [] if slot.is_over else self._send(Kind.CALL_SEEN, caller, head.slot, slot, now)
        if now - slot.sent_at < _ANSWER_PERIOD:
            return []
        return self._reply(caller, head.slot, slot, slot.reply, now)

    def _problem(self, peer: str, service: ServedService | None, body: bytes) -> str:
        """Return why a new call cannot run; empty if it can."""
        if service is None or not self._is_for(service, peer):
            return f"site {self._rules.site} does not serve it, or no longer does"
        if len(body) > MAX_CALL_SIZE:
            return f"the request is larger than {MAX_CALL_SIZE >> 20} MB"
        # A site may use at most as much as it leaves free, so that there is always room for one more site.
        sizes = [size for call, size in self._running.items() if call.peer == peer]
        if len(sizes) >= min(MAX_SLOTS, MAX_RUNNING - len(self._running)):
            return f"too many calls at once at site {self._rules.site}"
        if sum(sizes) + len(body) > MAX_RUNNING_BYTES - sum(self._running.values()):
            return f"too many large requests at once at site {self._rules.site}"
        return ""

    def on_result(self, call: CallId, status: Status, body: bytes, now: float) -> list[Action]:
        """Record how a call has ended, and return the resulting actions."""
        self._running.pop(call, None)
        caller = self.callers.get(call.peer)
        slot = caller.slots.get(call.slot) if caller is not None and caller.epoch == call.epoch else None
        if caller is None or slot is None or slot.number != call.number or slot.reply or slot.is_over:
            return []
        if status is Status.OK and len(body) > MAX_CALL_SIZE:
            status, body = Status.REFUSED, encode_error(f"the response is larger than {MAX_CALL_SIZE >> 20} MB")
        elif not self._has_room(caller, len(body)):
            status, body = Status.REFUSED, encode_error("too many large responses at once")
        return self._reply(caller, call.slot, slot, (status, body), now)

    def _has_room(self, caller: Caller, size: int) -> bool:
        """Return whether a reply of a given size may be kept. A site's replies may take at most as much as they leave
        free, so that there is always room for one more site.
        """
        free = MAX_ALL_REPLY_BYTES - size - sum(each.reply_bytes for each in self.callers.values())
        return caller.reply_bytes + size <= min(MAX_REPLY_BYTES, free)

    def _reply(self, caller: Caller, number: int, slot: _Slot, reply: tuple[Status, bytes], now: float) -> list[Action]:
        service = self._served.get(slot.service)
        if slot.reply is None and reply[0] is not Status.OK and service is not None:
            service.counts.fail(reply[1])
        slot.reply, slot.sent_at = reply, now
        return self._send(Kind.REPLY, caller, number, slot, now)

    def _send(self, kind: Kind, caller: Caller, number: int, slot: _Slot, now: float) -> list[Action]:
        """Return the action that sends a packet to the site's run that made the call, if it is still present."""
        peer = self._peers.get(caller.peer)
        if peer is None or not peer.is_present or peer.epoch != caller.epoch:
            return []
        status, body = slot.reply if kind is Kind.REPLY and slot.reply is not None else (Status.OK, b"")
        head = CallHead(kind, self._epoch, caller.epoch, number, slot.number, status, now)
        return [send(caller.peer, slot.service, head, body, slot.expires)]

    def on_reply_seen(self, peer: str, head: CallHead) -> None:
        """Discard a reply that another site has acknowledged."""
        slot = self._caller(peer).slots.get(head.slot)
        if slot is not None and slot.number == head.number and slot.reply is not None:
            slot.end()

    def drop_peer(self, peer: str) -> None:
        """End all calls of a site whose run has ended or is forgotten. Its slots are kept: if the run goes on, its
        calls must not be carried out again.
        """
        caller = self.callers.get(peer)
        for slot in caller.slots.values() if caller is not None else ():
            slot.end()

    def tick(self, now: float) -> list[Action]:
        """Return the actions that follow because time has passed."""
        actions: list[Action] = []
        for caller in self.callers.values():
            for number, slot in caller.slots.items():
                if slot.reply is None:
                    continue
                if now >= slot.expires:
                    slot.end()  # the caller has given up
                elif now - slot.sent_at >= repeat_period(len(slot.reply[1]), slot.repeats):
                    slot.repeats += 1
                    actions += self._reply(caller, number, slot, slot.reply, now)
        return actions
