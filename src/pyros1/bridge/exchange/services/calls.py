"""The services of other sites that this one provides, and local nodes' calls to them. No I/O.

A call is resent until the other site has seen it; that site then resends its reply until it is seen here. Each call
ends with exactly one result: a response, an error from the service, or an error from one of the bridges, at its
deadline at the latest.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import count
from typing import NamedTuple

from pyros1.bridge.exchange.actions import Action, Provide, Return, StopProviding
from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.exchange.services.call_packets import CallCounts, encode_error, repeat_period, send
from pyros1.bridge.names import SharedName, is_topic_name
from pyros1.bridge.protocol.calls import MAX_CALL_SIZE, MAX_SLOTS, CallHead, OfferedService, Status
from pyros1.bridge.protocol.packets import Kind
from pyros1.bridge.rules.rules import Rule, Rules
from pyros1.bridge.rules.services import DEFAULT_TIMEOUT, PARAMETERS, called
from pyros1.bridge.rules.site_access import may_serve

MAX_SERVICES = 1_000
"""Maximum number of another site's services that are provided on this site's master, where each must be registered."""
MAX_WAITING_BYTES = 128 << 20
"""Maximum total size in bytes of the requests of calls that have not ended."""
MAX_REFUSED = 1_000
"""Maximum number of services that are not provided here, but listed in the status."""
_MAYBE = "the call may have been carried out, or not"


class RemoteService(NamedTuple):
    """A service of another site, for the status.

    Attributes:
        peer: the site.
        offered: the service.
        local: its name here; empty if it is not provided here.
        state: why it is not provided; empty if it is.
        counts: the calls.
    """

    peer: str
    offered: OfferedService
    local: str
    state: str
    counts: CallCounts


class _Candidate:
    """A service of another site that a rule lets this site call."""

    def __init__(self, peer: str, offered: OfferedService, local: str, rule: Rule) -> None:
        self.peer = peer
        self.offered = offered
        self.local = local
        self.timeout = DEFAULT_TIMEOUT if rule.timeout is None else rule.timeout
        self.counts = CallCounts()
        self.problem = ""


class _Open:
    """A call that has not ended."""

    def __init__(self, token: int, number: int, service: SharedName, body: bytes, deadline: float) -> None:
        self.token = token
        self.number = number
        self.service = service
        self.body = body
        self.deadline = deadline
        self.counts: CallCounts | None = None
        self.is_seen = False
        self.repeats = 0
        self.sent_at = 0.0


_Source = tuple[str, SharedName]


class Calls:
    """The services of other sites, and the calls to them.

    Args:
        rules: the site's rules.
        epoch: the site's epoch.
        peers: the other sites; shared with the caller, which updates it.
    """

    def __init__(self, rules: Rules, epoch: int, peers: Mapping[str, Peer]) -> None:
        self._rules = rules
        self._epoch = epoch
        self._peers = peers
        self._numbers = count(1)
        self._candidates: dict[_Source, _Candidate] = {}
        self._refused: dict[_Source, tuple[OfferedService, str]] = {}
        self._readable: set[str] = set()  # the sites whose parameters this site may read
        self._provided: dict[str, _Candidate] = {}
        self._taken: Mapping[str, str] | None = None
        self._open: dict[str, dict[int, _Open]] = {}

    # Current state ----------------------------------------------------------------------------------------------------

    def set_offers(self, peer: str, offers: Iterable[OfferedService]) -> list[Action]:
        """Record which services another site serves, and return the resulting actions."""
        old = {source: candidate for source, candidate in self._candidates.items() if source[0] == peer}
        for source in old:
            del self._candidates[source]
        self._refused = {source: refused for source, refused in self._refused.items() if source[0] != peer}
        self._readable.discard(peer)
        accepted = 0
        for offered in offers:
            source = (peer, offered.service)
            if offered.service == (peer, PARAMETERS):
                self._readable.add(peer)
                continue
            rule = called(self._rules, offered.service, peer)
            local = "" if isinstance(rule, str) else self._rules.local_name(rule, offered.service)
            problem = rule if isinstance(rule, str) else ""
            if not problem and not is_topic_name(local):
                problem = "its name here would be too long"
            if not problem and accepted >= MAX_SERVICES:
                problem = "the site serves too many services"
            if problem or isinstance(rule, str):
                if len(self._refused) < MAX_REFUSED:
                    self._refused[source] = (offered, problem)
                continue
            accepted += 1
            before = old.get(source)
            same = before is not None and before.offered == offered
            self._candidates[source] = before if before and same else _Candidate(peer, offered, local, rule)
        return self._apply()

    def set_taken(self, taken: Mapping[str, str]) -> list[Action]:
        """Record which services other nodes of this site's master provide, by name, and return the resulting actions.
        Until this is called for the first time, no services are provided.
        """
        self._taken = taken
        return self._apply()

    def _apply(self) -> list[Action]:
        """Update the services provided here."""
        if self._taken is None:
            return []
        wanted: dict[str, _Candidate] = {}
        for source in sorted(self._candidates, key=lambda source: (not self._is_provided(source), source)):
            candidate = self._candidates[source]
            local, candidate.problem = candidate.local, ""
            if local in self._taken:
                candidate.problem = f"{self._taken[local]} already provides {local} here"
            elif local in wanted:
                candidate.problem = f"{local} is already {wanted[local].offered.service} here"
            else:
                wanted[local] = candidate
        gone = [local for local, candidate in self._provided.items() if wanted.get(local) is not candidate]
        actions: list[Action] = [StopProviding(local) for local in gone]
        actions += [
            Provide(local, *candidate.offered[1:])
            for local, candidate in wanted.items()
            if self._provided.get(local) is not candidate
        ]
        self._provided = wanted
        return actions

    def _is_provided(self, source: _Source) -> bool:
        candidate = self._candidates[source]
        return self._provided.get(candidate.local) is candidate

    def services(self) -> list[RemoteService]:
        """Return the services of other sites, for the status."""
        found = [
            RemoteService(each.peer, each.offered, each.local, each.problem, each.counts)
            for each in self._candidates.values()
        ]
        refused = [
            RemoteService(peer, offered, "", problem, CallCounts())
            for (peer, _), (offered, problem) in self._refused.items()
        ]
        return found + refused

    # Calls ------------------------------------------------------------------------------------------------------------

    def call(self, token: int, local: str, body: bytes, now: float) -> list[Action]:
        """Call a service that is provided here, and return the resulting actions. Exactly one `Return` for the token
        follows, now or later.

        Args:
            token: identifies the call.
            local: the service's name here.
            body: the encoded request.
            now: the current time.
        """
        candidate = self._provided.get(local)
        if candidate is None:
            return _fail(token, f"service {local} no longer exists")
        service, timeout = candidate.offered.service, candidate.timeout
        return self._begin(token, candidate.peer, service, body, timeout, candidate.counts, now)

    def ask_parameters(self, token: int, peer: str, request: bytes, timeout: float, now: float) -> list[Action]:
        """Ask another site for parameters, as `call` does for services.

        Args:
            token: identifies the request.
            peer: the site.
            request: see `pyros1.bridge.parameters`.
            timeout: maximum number of seconds.
            now: the current time.
        """
        service = SharedName(peer, PARAMETERS)
        if not may_serve(self._rules.access, peer, service):
            return _fail(token, f"site {peer} may not serve its parameters: `sites` here does not allow {service}")
        if peer in self._peers and self._peers[peer].is_present and peer not in self._readable:
            return _fail(
                token,
                f"site {peer} does not let this site read its parameters: run the bridge of {peer} with --params; if "
                f"its `sites` restricts {self._rules.site}, also allow {self._rules.site} to call {service}",
            )
        return self._begin(token, peer, service, request, timeout, None, now)

    def _begin(
        self,
        token: int,
        peer: str,
        service: SharedName,
        body: bytes,
        timeout: float,
        counts: CallCounts | None,
        now: float,
    ) -> list[Action]:
        if counts is not None:
            counts.calls += 1
        slots = self._open.setdefault(peer, {}) if peer in self._peers else {}
        problem = ""
        if peer not in self._peers:
            names = " ".join(sorted(self._peers)[:10])
            problem = f"there is no site {peer}; " + (f"there are: {names}" if names else "no other site was found")
        elif not self._peers[peer].is_present:
            problem = f"site {peer} does not respond"
        elif len(body) > MAX_CALL_SIZE:
            problem = f"the request is larger than {MAX_CALL_SIZE >> 20} MB"
        elif len(slots) >= MAX_SLOTS:
            problem = f"more than {MAX_SLOTS} calls at once to site {peer}"
        elif len(body) + sum(len(each.body) for calls in self._open.values() for each in calls.values()) > (
            MAX_WAITING_BYTES
        ):
            problem = "too many large requests at once"
        if problem:
            if counts is not None:
                counts.fail(problem.encode())
            return _fail(token, problem)
        call = _Open(token, next(self._numbers), service, body, now + timeout)
        call.counts = counts
        slot = next(number for number in range(MAX_SLOTS) if number not in slots)
        slots[slot] = call
        return [self._send(peer, slot, call, now)]

    def _send(self, peer: str, slot: int, call: _Open, now: float) -> Action:
        call.sent_at = now
        epoch, left = self._peers[peer].epoch, call.deadline - now
        head = CallHead(Kind.CALL, self._epoch, epoch, slot, call.number, Status.OK, now, left)
        return send(peer, call.service, head, call.body, min(call.deadline, now + repeat_period(len(call.body), 3)))

    def on_seen(self, peer: str, head: CallHead) -> None:
        """Record that another site has seen a call, so that it need not be resent."""
        call = self._open.get(peer, {}).get(head.slot)
        if call is not None and call.number == head.number:
            call.is_seen = True
            call.body = b""

    def on_reply(self, peer: str, service: SharedName, head: CallHead, body: bytes, now: float) -> list[Action]:
        """Handle a reply, which may come more than once, and return the resulting actions."""
        epoch = self._peers[peer].epoch
        seen = CallHead(Kind.REPLY_SEEN, self._epoch, epoch, head.slot, head.number, Status.OK, now)
        last = send(peer, service, seen, b"", now + repeat_period(0, 3))
        call = self._open.get(peer, {}).get(head.slot)
        if call is None or call.number != head.number or call.service != service:
            return [last]
        status = head.status
        if len(body) > MAX_CALL_SIZE:
            status, body = Status.REFUSED, encode_error(f"the response is larger than {MAX_CALL_SIZE >> 20} MB")
        elif status is Status.REFUSED:
            body = encode_error(f"{service}: ") + body
        return [*self._end(peer, head.slot, status, body), last]

    def _end(self, peer: str, slot: int, status: Status, body: bytes) -> list[Action]:
        call = self._open[peer].pop(slot)
        if status is not Status.OK and call.counts is not None:
            call.counts.fail(body)
        return [Return(call.token, status, body)]

    def fail_all(self, peer: str, reason: str) -> list[Action]:
        """End all calls to another site with an error.

        Args:
            peer: the site.
            reason: what has happened to it.
        """
        body = encode_error(f"{reason}; {_MAYBE}")
        slots = [*self._open.get(peer, ())]
        actions = [action for slot in slots for action in self._end(peer, slot, Status.REFUSED, body)]
        self._open.pop(peer, None)
        return actions

    def tick(self, now: float) -> list[Action]:
        """Return the actions that follow because time has passed."""
        actions: list[Action] = []
        for peer, slots in self._open.items():
            for slot, call in [*slots.items()]:
                if now >= call.deadline:
                    text = f"{call.service} has not answered in time; {_MAYBE}"
                    actions += self._end(peer, slot, Status.REFUSED, encode_error(text))
                elif not call.is_seen and now - call.sent_at >= repeat_period(len(call.body), call.repeats):
                    call.repeats += 1
                    actions.append(self._send(peer, slot, call, now))
        return actions


def _fail(token: int, text: str) -> list[Action]:
    return [Return(token, Status.REFUSED, encode_error(text))]
