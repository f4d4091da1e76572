"""Many subscribers of one publisher in one process, on bare sockets: ``drain.py drain links=N stuck=N seconds=S``.

A client library would let its subscribers share a connection, and take time for decoding: here nothing is measured but
the publisher. ``stuck`` further connections are made that never read. Prints ``figures rate=...``: messages per second
and subscriber.
"""

from __future__ import annotations

import os
import select
import socket
import sys
import time
import xmlrpc.client
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "peers"))

from harness import DEADLINE
from raw import connect, encode_header, read_header

TOPIC = "/bench"
SETTLE, FILL = 0.3, 1.0  # seconds from the first message to counting: without, with a subscriber that is stuck
BUFFER = 1 << 20


def publisher_address(topic: str = TOPIC) -> tuple[str, int]:
    """Where a topic's publisher serves it."""
    with xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]) as proxy:
        master: Any = proxy
        node = dict(master.getSystemState("/drain")[2][0])[topic][-1]
        uri = master.lookupNode("/drain", node)[2]
    with xmlrpc.client.ServerProxy(uri) as proxy:
        slave: Any = proxy
        _, host, port = slave.requestTopic("/drain", topic, [["TCPROS"]])[2]
    return host, port


def connect_small(host: str, port: int) -> socket.socket:
    """A connection that takes little before its sender has to wait, so that it is stuck soon."""
    link = socket.socket()
    link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    link.settimeout(DEADLINE)
    link.connect((host, port))
    return link


def main() -> None:
    options = dict(word.split("=", 1) for word in sys.argv[2:])
    count, stuck, seconds = int(options["links"]), int(options["stuck"]), float(options["seconds"])
    address = publisher_address()
    links = []
    for i in range(stuck + count):  # those that never read come first: a publisher reaches them before the others
        link = connect_small(*address) if i < stuck else connect(*address)
        header = {"callerid": f"/drain{i}", "topic": TOPIC, "type": "*", "md5sum": "*", "tcp_nodelay": "1"}
        link.sendall(encode_header(header))
        read_header(link)
        links.append(link)
    reading = {link.fileno(): link for link in links[stuck:]}
    received = dict.fromkeys(reading, 0)
    poll, buffer = select.epoll(), bytearray(BUFFER)
    for number, link in reading.items():
        link.setblocking(False)
        poll.register(number, select.EPOLLIN)

    def drain_until(end: float) -> None:
        while (left := end - time.perf_counter()) > 0:
            for number, _ in poll.poll(left):
                received[number] += reading[number].recv_into(buffer)

    first = reading[poll.poll(20)[0][0]]
    first.setblocking(True)
    frame = 4 + int.from_bytes(first.recv(4), "little")
    first.setblocking(False)
    drain_until(time.perf_counter() + (FILL if stuck else SETTLE))
    before, start = sum(received.values()), time.perf_counter()
    drain_until(start + seconds)
    took = time.perf_counter() - start
    print(f"figures rate={(sum(received.values()) - before) / frame / took / count:.2f}", flush=True)
    for link in links:
        link.close()


if __name__ == "__main__":
    main()
