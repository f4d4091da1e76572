"""Two sites that are present to each other, for tests of service calls between them."""

from __future__ import annotations

from itertools import count
from typing import Any

from pyros1.bridge.exchange.actions import Action, Send
from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.calls import CallHead, OfferedService, Status, decode_call_head
from pyros1.bridge.protocol.packets import Kind
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rules

OWN, THEIR = 11, 22
MD5 = "a" * 32
ADD = SharedName("red", "/add")


def rules(text: str, site: str = "base") -> Rules:
    return parse_config(text, "f", site).rules


def present(name: str, now: float = 0.0, epoch: int = THEIR) -> Peer:
    """Return another site that is present, whose clock is the same."""
    peer = Peer(name, OWN, count(1), now)
    peer.hear(epoch, now)
    _, ours = peer.make_heartbeat(now, 1, 1, (-1, -1), {})
    peer.on_heartbeat(epoch, OWN, ours._replace(echo=ours.number), now)
    assert peer.is_present
    return peer


def offered(name: str = "/add", site: str = "red", **changes: Any) -> OfferedService:
    service = OfferedService(SharedName(site, name), "a/B", MD5, "a/BRequest", "a/BResponse")
    return service._replace(**changes)


def packets(actions: list[Action]) -> list[tuple[CallHead, bytes]]:
    """Return the packets of calls in actions."""
    return [(decode_call_head(each.head), each.body) for each in actions if isinstance(each, Send)]


def kinds(actions: list[Action]) -> list[Kind]:
    return [head.kind for head, _ in packets(actions)]


def call_head(slot: int = 0, number: int = 1, sent_at: float = 0.0, left: float = 60.0) -> CallHead:
    return CallHead(Kind.CALL, THEIR, OWN, slot, number, Status.OK, sent_at, left)
