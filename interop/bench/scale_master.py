"""Many nodes at one master, light ones that only speak XML-RPC, and pyros1's: what one more costs.

What grows is measured between two sizes, so a figure "per node" is what the nodes that were added last have cost.
"""

from __future__ import annotations

import statistics
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from harness import STOCK_PYTHON, Master, Process, free_port, until
from master import Caller, request
from scale_nodes import TOPICS
from steps import figures_of
from vitals import cpu_clock, vitals

from pyros1.net.loop import Loop
from pyros1.net.xmlrpc_server import XmlRpcServer
from pyros1.wire.xmlrpc import loads_response

HERE = Path(__file__).resolve().parent
PARAMETERS = 50  # of each node
TYPE = "std_msgs/Float64"
START = 60.0  # seconds

Row = dict[str, Any]
"""Figures by name; besides, ``part``, ``side`` and the number ``nodes``."""


class Core(Master):
    """A master on the interpreter of stock, ours as well.

    Args:
        kind: ``ours`` or ``stock``.
        home: an empty folder.
        path: what this interpreter needs for pyros1.
        rosout: start the rosout node, too.
    """

    def __init__(self, kind: str, home: Path, path: str, rosout: bool) -> None:
        super().__init__(kind, home, free_port())
        self._path, self._rosout = path, rosout

    def start(self) -> None:
        """Start the master, and wait until it answers."""
        if self.kind == "stock":
            command = ["rosmaster", "--core", "-p", str(self.port)]
        else:
            command = [STOCK_PYTHON, "-m", "pyros1", "core" if self._rosout else "master", "-p", str(self.port)]
        self.core.append(Process(command, self.environ(PYTHONPATH=self._path), f"{self.kind} master"))
        self.await_up()
        if self._rosout:
            if self.kind == "stock":
                self.core.append(Process(["/usr/lib/rosout/rosout"], self.environ(), "rosout"))
            until(lambda: self.publishers("/rosout_agg"), "rosout")

    def program(self, role: str, **options: object) -> Process:
        """Start a program of scale_nodes.py."""
        words = [f"{key}={value}" for key, value in options.items()]
        command = [STOCK_PYTHON, str(HERE / "scale_nodes.py"), role, *words]
        return self.run(command, label=role, PYTHONPATH=self._path)

    @property
    def memory(self) -> float:
        """MB of the master, and of rosout if that is a process of its own."""
        return sum(vitals(process.pid).memory for process in self.core) / 1e6

    @property
    def cpu(self) -> float:
        """Seconds of processor time that both have used."""
        return sum(cpu_clock(process.pid) for process in self.core)


@contextmanager
def running(core: Core) -> Iterator[Core]:
    """Start and end a master with all its programs."""
    try:
        core.start()
        yield core
    finally:
        core.close()


class LightNodes:
    """Nodes in this process that have the names and the XML-RPC server of a node, and nothing else.

    Args:
        port: of the master.
    """

    def __init__(self, port: int) -> None:
        self.caller = Caller(port)
        self.longest = 0.0
        self._loop = Loop("light nodes")
        self._loop.start()
        self._servers: list[XmlRpcServer] = []
        self._told = threading.Semaphore(0)

    def close(self) -> None:
        for server in self._servers:
            server.close()
        self._loop.stop()
        self.caller.sock.close()

    def call(self, method: str, *params: object) -> Any:
        """Call the master; the longest call is remembered."""
        data = request(method, *params)
        began = time.perf_counter()
        body = self.caller.exchange(data)
        self.longest = max(self.longest, time.perf_counter() - began)
        code, message, value = loads_response(body)
        assert code == 1, f"{method}: {message}"
        return value

    def await_told(self, count: int) -> None:
        """Wait until so many notifications have arrived."""
        for _ in range(count):
            assert self._told.acquire(timeout=30), "a notification did not arrive"

    def grow(self, size: int) -> None:
        """Add nodes up to this number, and wait until all that are to be told of publishers have been."""
        first = len(self._servers)
        for i in range(first, size):
            server = XmlRpcServer(self._loop, self._dispatch, bind_host="127.0.0.1", advertised_host="127.0.0.1")
            self._servers.append(server)
            name, api = f"/light{i}", server.uri
            self.call("setParam", name, name, {f"p{j}": j * 0.5 for j in range(PARAMETERS)})
            for j in range(TOPICS):
                self.call("registerPublisher", name, f"/n{i}/t{j}", TYPE, api)
            for j in range(TOPICS):  # the next node's: this one will be told of it
                self.call("registerSubscriber", name, f"/n{i + 1}/t{j}", TYPE, api)
            self.call("registerService", name, f"{name}/get_loggers", f"rosrpc://127.0.0.1:{server.port}", api)
            self.call("subscribeParam", name, api, f"{name}/p0")
            self.call("registerSubscriber", name, "/fan", TYPE, api)
        self.await_told(TOPICS * (size - max(first, 1)))

    def fan_out(self, uri: str) -> None:
        """A publisher of /fan comes: all nodes are told. And goes."""
        for method, rest in (("registerPublisher", (TYPE, uri)), ("unregisterPublisher", (uri,))):
            self.call(method, "/fan_publisher", "/fan", *rest)
            self.await_told(len(self._servers))

    def _dispatch(self, method: str, params: object) -> list[object]:
        if method == "publisherUpdate":
            self._told.release()
        return [1, "", 0]


def light(core: Core, sizes: list[int]) -> Iterator[Row]:
    """Registrations, notifications and questions, of nodes that cost nothing themselves."""
    nodes, before = LightNodes(core.port), 0
    try:
        for size in sizes:
            added, before = size - before, size
            nodes.longest, memory, used, began = 0.0, core.memory, core.cpu, time.perf_counter()
            nodes.grow(size)
            took, used = time.perf_counter() - began, core.cpu - used
            row: Row = {"part": "light", "side": core.kind, "nodes": size, "topics": size * TOPICS}
            row |= {"wall": took / added * 1e3, "cpu": used / added * 1e3, "longest": nodes.longest * 1e3}
            row |= {"rss": (core.memory - memory) * 1e3 / added, "memory": core.memory}
            row |= questions(core, nodes, size)
            yield row
    finally:
        nodes.close()


def questions(core: Core, nodes: LightNodes, size: int) -> Row:
    """What single calls cost a master of this size: milliseconds of its processor time."""
    node, parameter = f"/light{size // 2}", f"/light{size // 2}/p7"

    def change() -> None:
        nodes.call("registerPublisher", "/light0", "/n0/t0", TYPE, "http://127.0.0.1:9/")

    def state() -> None:
        nodes.call("getSystemState", "/tool")

    first = nodes.call("lookupNode", "/tool", "/light0")
    row: Row = {
        "lookup": cost(core, lambda: nodes.call("lookupNode", "/tool", node), 100)[1],
        "get": cost(core, lambda: nodes.call("getParam", "/tool", parameter), 100)[1],
        "set": cost(core, lambda: nodes.call("setParam", "/tool", parameter, 0.5), 100)[1],
        "names": cost(core, lambda: nodes.call("getParamNames", "/tool"), 3)[1],
    }
    walls, used = [], []
    for turn in range(3):
        nodes.call("registerService", "/light0", f"/again{turn}", "rosrpc://127.0.0.1:9", first)
        wall, cpu = cost(core, state, 1)
        walls.append(wall)
        used.append(cpu)
    row |= {"state_wall": statistics.median(walls), "state": statistics.median(used)}
    row["state_again"] = cost(core, state, 5)[1]
    wall, cpu = cost(core, lambda: nodes.fan_out("http://127.0.0.1:9/"), 3)
    row |= {"told_wall": wall / 2, "told": cpu / 2, "told_each": cpu / 2 / size * 1e3}
    return row


def cost(core: Core, do: Callable[[], object], count: int) -> tuple[float, float]:
    """Milliseconds that something takes, and those that it costs the master, on average."""
    used, began = core.cpu, time.perf_counter()
    for _ in range(count):
        do()
    return (time.perf_counter() - began) / count * 1e3, (core.cpu - used) / count * 1e3


def crowds(core: Core, sizes: list[int], each: int, idle: float) -> Iterator[Row]:
    """Nodes of pyros1, so many in a process; and a new publisher that all of them subscribe to.

    Args:
        core: a master with rosout.
        sizes: numbers of nodes.
        each: nodes in a process; sizes are multiples of it.
        idle: seconds for which the master is watched while nothing happens.
    """
    crowd: list[Process] = []
    for size in sizes:
        memory, used, starting, added = core.memory, core.cpu, [], 0
        while len(crowd) * each < size:
            process = core.program("crowd", first=len(crowd) * each, count=each)
            crowd.append(process)
            starting.append(figures_of(process, START))
            added += each
        row: Row = {"part": "nodes", "side": core.kind, "nodes": size, "topics": size * (TOPICS + 1)}
        row |= {f"own_{name}": statistics.mean(one[name] for one in starting) for name in starting[0]}
        time.sleep(min(idle, 1.0))  # what registrations leave to do has been done
        row |= {"cpu": (core.cpu - used) / added * 1e3, "rss": (core.memory - memory) * 1e3 / added}
        row["memory"] = core.memory
        used, theirs = core.cpu, sum(cpu_clock(process.pid) for process in crowd)
        time.sleep(idle)
        row["idle"] = (core.cpu - used) / idle * 100
        row["own_idle"] = (sum(cpu_clock(process.pid) for process in crowd) - theirs) / idle / size * 100
        yield row | linking(core, crowd, size)
    for process in crowd:
        assert process.child.stdin is not None
        process.child.stdin.close()
    for process in crowd:
        process.wait(START)


def linking(core: Core, crowd: list[Process], size: int) -> Row:
    """How long it takes until all nodes are linked to a new publisher, and then until all have a message of it."""
    fan = core.program("fan", count=size)
    fan.wait_line("^ready")
    walls, own, master, theirs, heard = [], [], [], [], []
    for _ in range(3):
        before = core.cpu, sum(cpu_clock(process.pid) for process in crowd)
        fan.write("go")
        linked = fan.wait_line(r"^linked (\S+) (\S+)", START)
        walls.append(float(linked[1]) * 1e3)
        own.append(float(linked[2]) * 1e6 / size)
        master.append((core.cpu - before[0]) * 1e6 / size)
        theirs.append((sum(cpu_clock(process.pid) for process in crowd) - before[1]) * 1e6 / size)
        sent = float(fan.wait_line(r"^sent (\S+)")[1])
        heard.append((max(float(one.wait_line(r"^heard (\S+)")[1]) for one in crowd) - sent) * 1e3)
        fan.wait_line("^gone")
    fan.close()
    core.processes.remove(fan)
    names = ("linked", "linked_publisher", "linked_master", "linked_subscriber", "heard")
    medians = map(statistics.median, (walls, own, master, theirs, heard))
    return dict(zip(names, medians, strict=True))
