"""Load on the master, ours beside stock's: calls, trees, states, fan-out, many callers. Prints rates and ratios.

Run: python interop/bench/master.py [--rounds N], or with ``--side ours`` or ``stock`` for the figures of one as JSON.
Needs Debian's python3-rosmaster; pyros1 must be importable.
The callers speak HTTP over plain sockets with requests made beforehand, so that what is measured is the master.
"""

from __future__ import annotations

import argparse
import json
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from pyros1.net.loop import Loop
from pyros1.net.xmlrpc_server import XmlRpcServer
from pyros1.wire.http import ResponseParser, build_request
from pyros1.wire.xmlrpc import dumps_call, loads_response

API = "http://127.0.0.1:9/"
TREE = {f"k{i}": {f"j{j}": j * 0.5 for j in range(20)} for i in range(50)}
TOPICS = 1000
SUBSCRIBERS = 50
APART = 0.002
CALLERS = 16
FIGURES = {
    "setParam": "calls/s",
    "getParam": "calls/s",
    "setParam, tree of 1000": "calls/s",
    "getParam, tree of 1000": "calls/s",
    "registerPublisher": "calls/s",
    "getSystemState, 1000 topics": "calls/s",
    "lookupNode": "calls/s",
    "unregisterPublisher": "calls/s",
    f"getParam, {CALLERS} callers": "calls/s",
    "getParam: CPU of a call": "us",
    "getParam, calls 2 ms apart: median": "us",
    "getParam, calls 2 ms apart: CPU of a call": "us",
    "registerPublisher, calls 2 ms apart: CPU of a call": "us",
    f"publisherUpdate to {SUBSCRIBERS} nodes": "ms",
    f"publisherUpdate to {SUBSCRIBERS} on one node": "ms",
}


class Caller:
    """One kept connection."""

    def __init__(self, port: int) -> None:
        self.sock = socket.create_connection(("127.0.0.1", port))
        self.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def exchange(self, request: bytes) -> bytes:
        self.sock.sendall(request)
        parser = ResponseParser()
        while True:
            data = self.sock.recv(1 << 18)
            if not data:
                raise ConnectionError("the master closed the connection")
            parser.feed(data)
            response = parser.next_message()
            if response is not None:
                return response.body

    def call(self, method: str, *params: object) -> object:
        code, message, value = loads_response(self.exchange(request(method, *params)))
        if code != 1:
            raise RuntimeError(f"{method}: {message}")
        return value


def request(method: str, *params: object) -> bytes:
    return build_request("127.0.0.1", "/", dumps_call(method, params))


def rate(caller: Caller, requests: list[bytes]) -> float:
    for one in requests[:20]:
        caller.exchange(one)
    began = time.perf_counter()
    for one in requests:
        caller.exchange(one)
    return len(requests) / (time.perf_counter() - began)


def cpu_seconds(pid: int) -> float:
    """What a process has used of the processor so far, user and system."""
    return time.clock_gettime((~pid << 3) | 2)  # as clock_getcpuclockid


def costs(caller: Caller, pid: int) -> list[float]:
    """Microseconds of small calls: the processor's and, for calls with a pause between them, until the answer."""
    kind = "std_msgs/Float64"
    asking = [request("getParam", "/b", f"/bench/p{i % 100}") for i in range(2000)]
    registering = [request("registerPublisher", f"/cn{i}", f"/ct{i}", kind, API) for i in range(200)]
    for i in range(100):
        caller.call("setParam", "/b", f"/bench/p{i}", i)
    used = cpu_seconds(pid)
    for one in asking:
        caller.exchange(one)
    found = [(cpu_seconds(pid) - used) / len(asking)]
    for requests in (asking[:200], registering):
        used, times = cpu_seconds(pid), []
        for one in requests:
            time.sleep(APART)
            began = time.perf_counter()
            caller.exchange(one)
            times.append(time.perf_counter() - began)
        time.sleep(APART)
        found += [statistics.median(times), (cpu_seconds(pid) - used) / len(requests)]
    return [seconds * 1e6 for seconds in found[:3] + found[4:]]


def fan_out(caller: Caller, one_node: bool) -> float:
    """Median milliseconds from a registration to the last of the subscribers' notifications."""
    with ExitStack() as stack:
        loop = Loop("subscribers")
        loop.start()
        stack.callback(loop.stop)
        arrived = threading.Semaphore(0)

        def dispatch(method: str, params: object) -> list[object]:
            arrived.release()
            return [1, "", 0]

        servers = []
        for _ in range(1 if one_node else SUBSCRIBERS):
            server = XmlRpcServer(loop, dispatch, bind_host="127.0.0.1", advertised_host="127.0.0.1")
            stack.callback(server.close)
            servers.append(server)
        topic = f"/fan{one_node:d}"
        for i in range(SUBSCRIBERS):
            caller.call(
                "registerSubscriber", f"/s{one_node:d}_{i}", topic, "std_msgs/Float64", servers[i % len(servers)].uri
            )
        times = []
        for i in range(9):
            began = time.perf_counter()
            caller.call("registerPublisher", f"/fp{one_node:d}_{i}", topic, "std_msgs/Float64", API)
            for _ in range(SUBSCRIBERS):
                if not arrived.acquire(timeout=20):
                    raise RuntimeError("a notification did not arrive")
            times.append(time.perf_counter() - began)
        for i in range(SUBSCRIBERS):
            caller.call("unregisterSubscriber", f"/s{one_node:d}_{i}", topic, servers[i % len(servers)].uri)
        return statistics.median(times) * 1e3


def many_callers(port: int) -> float:
    """All callers ask at the same time, again and again; one thread serves them, so that it does not set the pace."""
    one = request("getParam", "/b", "/bench/p1")
    rounds = 300
    callers = [Caller(port) for _ in range(CALLERS)]
    began = time.perf_counter()
    for _ in range(rounds):
        for caller in callers:
            caller.sock.sendall(one)
        for caller in callers:
            answer = caller.sock.recv(4096)
            while not answer.rstrip().endswith(b"</methodResponse>"):
                answer += caller.sock.recv(4096)
    return CALLERS * rounds / (time.perf_counter() - began)


def measure(port: int, pid: int) -> dict[str, float]:
    """The figures of one master, by its port and its process, in the order of FIGURES."""
    caller = Caller(port)
    kind = "std_msgs/Float64"
    rates = [
        rate(caller, [request("setParam", "/b", f"/bench/p{i % 100}", i) for i in range(2000)]),
        rate(caller, [request("getParam", "/b", f"/bench/p{i % 100}") for i in range(2000)]),
        rate(caller, [request("setParam", "/b", "/tree", TREE)] * 50),
        rate(caller, [request("getParam", "/b", "/tree")] * 50),
        rate(caller, [request("registerPublisher", f"/bn{i}", f"/bt{i}", kind, API) for i in range(TOPICS)]),
        rate(caller, [request("getSystemState", "/b")] * 50),
        rate(caller, [request("lookupNode", "/b", f"/bn{i}") for i in range(TOPICS)]),
        rate(caller, [request("unregisterPublisher", f"/bn{i}", f"/bt{i}", API) for i in range(TOPICS)]),
        many_callers(port),
        *costs(caller, pid),
        fan_out(caller, one_node=False),
        fan_out(caller, one_node=True),
    ]
    return dict(zip(FIGURES, rates, strict=True))


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as sock:
        return int(sock.getsockname()[1])


OURS = """
import sys
from pyros1.master import Master
master = Master(port=int(sys.argv[1]), bind_host="127.0.0.1")
master.start()
sys.stdin.read()
master.stop()
"""


@contextmanager
def running(command: Callable[[int], list[str]]) -> Iterator[tuple[int, int]]:
    """A master; yields its port and its process id."""
    port = free_port()
    with tempfile.TemporaryDirectory() as home:
        environ = dict(os.environ, ROS_HOME=home, ROS_HOSTNAME="localhost")
        process = subprocess.Popen(
            command(port), env=environ, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            limit = time.monotonic() + 20
            while True:
                try:
                    Caller(port).sock.close()
                    break
                except OSError:
                    if time.monotonic() > limit:
                        raise
                    time.sleep(0.05)
            yield port, process.pid
        finally:
            process.terminate()
            process.communicate()


MASTERS: dict[str, Callable[[int], list[str]]] = {
    "stock": lambda port: ["/usr/bin/python3", "/usr/bin/rosmaster", "--core", "-p", str(port)],
    "ours": lambda port: [sys.executable, "-c", OURS, str(port)],
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3, help="measure each this often, alternating; the median counts")
    parser.add_argument("--side", choices=MASTERS, help="measure only this one, once")
    options = parser.parse_args()
    if options.side:
        with running(MASTERS[options.side]) as master:
            print(json.dumps(measure(*master)))
        return 0
    found: dict[str, list[dict[str, float]]] = {name: [] for name in MASTERS}
    for _ in range(options.rounds):
        for name, command in MASTERS.items():
            with running(command) as master:
                found[name].append(measure(*master))
    print(f"{'':36}{'unit':>10}{'stock':>12}{'ours':>12}{'ratio':>8}")
    for what, unit in FIGURES.items():
        stock, ours = (statistics.median(one[what] for one in found[name]) for name in MASTERS)
        ratio = stock / ours if unit in ("ms", "us") else ours / stock
        print(f"{what:36}{unit:>10}{stock:12.1f}{ours:12.1f}{ratio:8.2f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
