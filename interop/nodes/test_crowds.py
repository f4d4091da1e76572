"""Ten thousand connections that say nothing, or too little: a master and a node go on, in little memory.

Feature: 10,000 connections that send nothing, or too little -- a master and a node keep working, with little memory
"""

from __future__ import annotations

import itertools
import re
import resource
import signal
import sys
import xmlrpc.client
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import Master, Peer, Process, free_port

CROWD = 10_000
ROOM = 64 << 20
"""Bytes of memory that a process may take more than before."""
MAX_CONNECTIONS = 4096
"""That a server of XML-RPC keeps, if it may open twice as many files."""
TYPE = "std_msgs/String"

ATTACK = """
import resource, socket, struct, sys
count, first, drip = int(sys.argv[1]), bytes.fromhex(sys.argv[2]), bytes.fromhex(sys.argv[3])
most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
peers = []
for number in range(count):
    address = ("localhost", int(sys.argv[4 + number % (len(sys.argv) - 4)]))
    peers.append(socket.create_connection(address, timeout=60))
    peers[-1].settimeout(0.1)
    peers[-1].sendall(first)
print("there are", len(peers), flush=True)
while True:  # byte by byte
    for byte in drip:
        for peer in peers:
            try:
                peer.send(bytes([byte]))
            except OSError:
                pass  # it was closed to make room
    print("dripped", flush=True)
    if not sys.stdin.readline():
        break
"""
HEAD = b"POST /RPC2 HTTP/1.1\r\nContent-Length: 99999999\r\n\r\n"
GREETING = b"\xff\xff\x0f\0\x30\0\0\0message_definition="


def memory(process: Process) -> int:
    """Return the bytes that a process has in memory."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+) kB", status)[1]) << 10  # type: ignore[index]


@pytest.fixture
def core(tmp_path: Path) -> Iterator[Master]:
    """A core of this test alone."""
    master = Master("ours", tmp_path / "home", free_port())
    master.start()
    yield master
    master.close()


def attack(core: Master, count: int, ports: list[int], first: bytes = b"", drip: bytes = b"") -> Process:
    """Open connections to ports; each begins with the same bytes. Return the attacker, who holds them."""
    words = [str(count), first.hex(), drip.hex(), *map(str, ports)]
    attacker = Process([sys.executable, "-c", ATTACK, *words], core.environ(), "attacker")
    core.processes.append(attacker)
    attacker.wait_line(rf"there are {count}", timeout=60)
    return attacker


def ports_of(core: Master, peer: Peer) -> tuple[int, int]:
    """Return the ports of a node: of its API and of its topics."""
    api = core.call("lookupNode", peer.name)[2]
    with xmlrpc.client.ServerProxy(api) as proxy:
        offer = proxy.requestTopic("/harness", "/chat", [["TCPROS"]])
    return int(api.rstrip("/").rpartition(":")[2]), int(offer[2][2])  # type: ignore[index,call-overload]


@pytest.fixture
def robot(core: Master) -> tuple[Master, Peer, Peer]:
    """A core, a publisher of ours and a stock subscriber that hears it."""
    sender, receiver = core.ready_peer("pyros1", "sender"), core.ready_peer("roscpp", "receiver")
    sender.advertise("/chat", TYPE)
    receiver.subscribe("/chat", TYPE)
    sender.linked("/chat")
    receiver.linked("/chat")
    return core, sender, receiver


_seeds = itertools.count(1)


def lives(core: Master, sender: Peer, receiver: Peer) -> None:
    """Check that the master answers, and that messages arrive."""
    assert core.call("getPid")[0] == 1
    assert core.node(sender.name, "getPid")[0] == 1
    assert sender.publish("/chat", seed := next(_seeds)) == receiver.received("/chat"), seed


def test_ten_thousand_connections_leave_master_and_node_alive(robot: tuple[Master, Peer, Peer]) -> None:
    core, sender, receiver = robot
    watched = [core.core[0], sender]
    before = [memory(process) for process in watched]
    ports = [core.port, *ports_of(core, sender)]
    attack(core, CROWD, ports)  # they say nothing
    lives(core, sender, receiver)
    late = core.ready_peer("roscpp", "late")
    late.subscribe("/chat", TYPE)
    late.linked("/chat")
    assert sender.publish("/chat", 99) == late.received("/chat") == receiver.received("/chat")
    for process, size in zip(watched, before, strict=True):
        assert memory(process) < size + ROOM, process.label
        assert len(list(Path(f"/proc/{process.pid}/fd").iterdir())) < MAX_CONNECTIONS + 500, process.label


def test_requests_and_headers_that_come_byte_by_byte_hold_up_nobody(robot: tuple[Master, Peer, Peer]) -> None:
    core, sender, receiver = robot
    watched = [core.core[0], sender]
    before = [memory(process) for process in watched]
    api, topics = ports_of(core, sender)
    requests = attack(core, 1200, [core.port, api], HEAD, b"<methodCall>")
    headers = attack(core, 600, [topics], GREETING, b"int32 a\n")
    for attacker in (requests, headers):
        attacker.wait_line("dripped", timeout=60)
    lives(core, sender, receiver)
    for process, size in zip(watched, before, strict=True):
        assert memory(process) < size + ROOM, process.label


def test_who_takes_all_descriptors_takes_them_for_himself_only(core: Master) -> None:
    """Subscribers are not closed for others: when there is no room for more, those who are there still get messages."""
    sender, receiver = core.ready_peer("pyros1", "sender"), core.ready_peer("roscpp", "receiver")
    sender.advertise("/chat", TYPE)
    receiver.subscribe("/chat", TYPE)
    sender.linked("/chat")
    _, topics = ports_of(core, sender)
    resource.prlimit(sender.pid, resource.RLIMIT_NOFILE, (64, 64))
    fields = [b"topic=/chat", b"md5sum=*", b"type=*", b"callerid=/crowd", b"tcp_nodelay=0"]
    body = b"".join(len(field).to_bytes(4, "little") + field for field in fields)
    crowd = attack(core, 150, [topics], len(body).to_bytes(4, "little") + body)
    assert sender.publish("/chat", 1) == receiver.received("/chat")
    crowd.signal(signal.SIGKILL)
    crowd.wait()
    late = core.ready_peer("roscpp", "late")
    late.subscribe("/chat", TYPE)
    late.linked("/chat")
    assert sender.publish("/chat", 2) == late.received("/chat")
