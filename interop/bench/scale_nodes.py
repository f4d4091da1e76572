"""The programs that scale.py starts, on pyros1: ``scale_nodes.py ROLE KEY=VALUE ...``.

| role | does | prints |
|---|---|---|
| crowd | ``count`` light nodes from number ``first`` on | ``figures`` per node; ``heard`` when all had a message |
| fan | for each line of input a new publisher of /fan, until ``count`` subscribers are linked | ``linked``, ``sent`` |
| prime | publishes on ``out`` until somebody publishes ``until`` | ``ready`` |
| last | ``links`` bare subscribers of /ping; a message on /pong when the last one has it | ``ready``, ``figures`` |
"""

from __future__ import annotations

import resource
import select
import signal
import socket
import sys
import threading
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "peers"))

from drain import publisher_address
from raw import connect, encode_header, read_header
from roles import cpu_seconds, figures, now, ready, share, status

from pyros1 import Node
from pyros1.msgs import load_message

TOPICS = 5
FLOAT = load_message("std_msgs/Float64")
FRAME = 12  # bytes of a Float64 on the wire


def raise_file_limit() -> None:
    """Let this process and its children open as many files as the system allows."""
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


def crowd(options: dict[str, str]) -> None:
    """Light nodes: each publishes some topics, and subscribes to /fan and to one of the node before."""
    first, count = int(options["first"]), int(options["count"])
    heard = Heard(count)
    memory, threads, used, began = status("VmRSS"), status("Threads"), cpu_seconds(), now()
    nodes = []
    for i in range(first, first + count):
        node = Node(f"crowd{i}", argv=[], handle_signals=False)
        for j in range(TOPICS):
            node.advertise(f"/n{i}/t{j}", FLOAT, queue_size=10)
        node.subscribe("/fan", FLOAT, heard, queue_size=10)
        node.subscribe(f"/n{max(i - 1, 0)}/t0", FLOAT, leave, queue_size=10)
        nodes.append(node)
    took, used = now() - began, cpu_seconds() - used
    figures(
        wall=took / count * 1e3,
        cpu=used / count * 1e3,
        rss=(status("VmRSS") - memory) / count,
        threads=(status("Threads") - threads) / count,
    )
    for _ in sys.stdin:
        pass
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for node in nodes:
        node.shutdown()


def leave(message: Any) -> None:
    """A callback that does nothing."""


class Heard:
    """Says when all nodes of the crowd have had a message.

    Args:
        count: number of nodes.
    """

    def __init__(self, count: int) -> None:
        self._count = self._left = count
        self._lock = threading.Lock()

    def __call__(self, message: Any) -> None:
        with self._lock:
            self._left -= 1
            if self._left:
                return
            self._left = self._count
        print(f"heard {time.monotonic():.6f}", flush=True)


def fan(options: dict[str, str]) -> None:
    """The time from `advertise` until so many subscribers are linked; then one message."""
    count = int(options["count"])
    node = Node("fan", anonymous=True, argv=[], handle_signals=False)
    ready()
    for _ in sys.stdin:
        used, began = cpu_seconds(), now()
        publisher = node.advertise("/fan", FLOAT, queue_size=10)
        while publisher.num_connections < count:
            time.sleep(0.001)
        print(f"linked {now() - began:.6f} {cpu_seconds() - used:.6f}", flush=True)
        print(f"sent {time.monotonic():.6f}", flush=True)
        publisher.publish(1.0)
        time.sleep(0.2)  # it is heard
        publisher.unregister()
        print("gone", flush=True)
    node.shutdown()


def prime(options: dict[str, str]) -> None:
    """A relay knows its type only when it has had a message."""
    node = Node("prime", anonymous=True, argv=[], handle_signals=False)
    publisher = node.advertise(options["out"], FLOAT, queue_size=10)
    while options["until"] not in dict(node.master.get_published_topics("")):
        publisher.publish(0.0)
        time.sleep(0.05)
    time.sleep(0.5)
    node.shutdown()
    ready()


def last(options: dict[str, str]) -> None:
    """Subscribers that read at once; how long after the first one the last one has a message."""
    address, links = publisher_address("/ping"), {}
    for i in range(int(options["links"])):
        link = connect(*address)
        link.sendall(
            encode_header({"callerid": f"/last{i}", "topic": "/ping", "type": "*", "md5sum": "*", "tcp_nodelay": "1"})
        )
        read_header(link)
        link.setblocking(False)
        links[link.fileno()] = link
    ready()
    node = Node("last", argv=[], handle_signals=False)
    publisher = node.advertise("pong", FLOAT, queue_size=10)
    spreads: list[float] = []
    signal.signal(signal.SIGINT, lambda *_: end(spreads))
    answer(links, lambda: publisher.publish(1.0), spreads)


def answer(links: dict[int, socket.socket], reply: Any, spreads: list[float]) -> None:
    """Read the messages, and answer when all links have one."""
    poll = select.epoll()
    for number in links:
        poll.register(number, select.EPOLLIN)
    whole, came, first = FRAME * len(links), 0, 0.0
    while True:
        for number, _ in poll.poll():
            if not came:
                first = now()
            came += len(links[number].recv(4096))
        if came >= whole:
            spreads.append(now() - first)
            came -= whole
            reply()


def end(spreads: list[float]) -> None:
    figures(spread=share(spreads, 0.5), n=len(spreads))
    sys.exit(0)


def main() -> None:
    raise_file_limit()
    role, *rest = sys.argv[1:]
    {"crowd": crowd, "fan": fan, "prime": prime, "last": last}[role](dict(word.split("=", 1) for word in rest))


if __name__ == "__main__":
    main()
