"""Many links of one node, and a message through many nodes: the programs of run.py, with more of everything.

All programs are under a stock master, so that nothing differs but the library.
"""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Iterator
from typing import Any

from harness import STOCK_PYTHON, Process, until
from model import OURS
from scale_master import START, Core, Row
from steps import Bench, Program, figures_of
from vitals import cpu_clock, vitals

RELAYS = {
    OURS: [STOCK_PYTHON, "-m", "pyros1", "topic_tools", "relay"],
    "topic_tools": ["/usr/lib/topic_tools/relay"],
}


def one_publisher(core: Core, bench: Bench, kind: str, links: int) -> Row:
    """A publisher with many subscribers on bare sockets: what they get of a flood, and when the last has it."""
    row: Row = {"part": "publisher", "side": kind, "links": links}
    mark = len(core.processes)
    try:
        publisher = bench.start(Program(kind, "pub", f"type=Float64 queue=1000 wait={links}"), bench.seconds + 3)
        publisher.wait_line("^ready", START)
        drain = bench.start(Program("drain", "drain", f"links={links} stuck=0"), bench.seconds)
        until(lambda: len(os.listdir(f"/proc/{publisher.pid}/fd")) > links, "all links", START)
        time.sleep(min(bench.seconds, 1.0))
        used, began = cpu_clock(publisher.pid), time.perf_counter()
        time.sleep(bench.seconds / 2)
        share = (cpu_clock(publisher.pid) - used) / (time.perf_counter() - began)
        rate = figures_of(drain, START)["rate"] * links
        row |= {"rate": rate, "cpu": share * 1e6 / rate if rate else float("nan"), "share": share * 100}
        drain.close()
        publisher.close()
        ping = bench.start(Program(kind, "ping", "type=Float64"), bench.seconds)
        until(lambda: core.publishers("/ping"), "the publisher")
        last = core.program("last", links=links)
        last.wait_line("^ready", START)
        until(lambda: core.publishers("/pong"), "the answer")
        figures = figures_of(ping, START + bench.seconds)
        row |= {"p50": figures["p50"] / 1e3, "p99": figures["p99"] / 1e3, "rounds": figures["n"]}
        last.close()
        row["spread"] = float(re.findall(r"^figures spread=(\S+)", "\n".join(last.lines), re.MULTILINE)[0]) / 1e3
    finally:
        core.close_since(mark)
    return row


def one_node(core: Core, bench: Bench, kind: str, count: int, idle: float) -> Row:
    """A node that subscribes to many topics on which nothing comes."""
    row: Row = {"part": "subscriptions", "side": kind, "topics": count}
    mark = len(core.processes)
    try:
        publisher = bench.start(Program(kind, "many", f"type=Float64 count={count}"), START)
        publisher.wait_line("^ready", START)
        began = time.perf_counter()
        node = bench.start(Program(kind, "idle", f"type=Float64 count={count}"), START)
        linked = f"/proc/{node.pid}/fd"
        until(lambda: len(os.listdir(linked)) > count, "files for all links", START)
        until(lambda: links_of(core, "/idle0") >= count, "all links", START)
        row |= {"linked": time.perf_counter() - began, "cpu": cpu_clock(node.pid)}
        time.sleep(1.5)  # what links leave to do has been done; the program ends some six seconds after the last link
        now, used = vitals(node.pid), cpu_clock(node.pid)
        row |= {"memory": now.memory / 1e6, "threads": now.threads}
        time.sleep(idle)
        row["idle"] = (cpu_clock(node.pid) - used) / idle * 100
        node.signal(signal.SIGKILL)  # it would sleep on
    finally:
        core.close_since(mark)
    return row


def links_of(core: Core, topic: str) -> int:
    """How many links the node that subscribes to a topic has, as it says itself."""
    return sum(1 for link in core.node(core.subscribers(topic)[0], "getBusInfo")[2] if link[2] == "i" and link[5])


def relays(core: Core, bench: Bench, side: str, count: int) -> Row:
    """The round trip of a message through so many relays, each a process, with pyros1's sender and receiver."""
    mark = len(core.processes)
    try:
        chain = [relay(core, bench, side, i, count) for i in range(count)]
        core.program("prime", out="/ping", until="/pong").wait_line("^ready", START)
        used = sum(cpu_clock(one.pid) for one in chain)
        figures = figures_of(bench.start(Program(OURS, "ping", "type=Float64"), bench.seconds), START + bench.seconds)
        used = sum(cpu_clock(one.pid) for one in chain) - used
        memory = sum(vitals(one.pid).memory for one in chain) / count / 1e6
        return {"p50": figures["p50"], "p99": figures["p99"], "cpu": used / figures["n"] / count * 1e6, "rss": memory}
    finally:
        core.close_since(mark)


def relay(core: Core, bench: Bench, side: str, number: int, count: int) -> Process:
    """Start a relay of a chain from /ping to /pong."""
    source = f"/hop{number}" if number else "/ping"
    out = f"/hop{number + 1}" if number + 1 < count else "/pong"
    variables: dict[str, Any] = bench._variables(OURS) if side == OURS else {}
    return core.run([*RELAYS[side], source, out, f"__name:=relay{number}"], label=f"{side} relay", **variables)


def chain(core: Core, bench: Bench, side: str, count: int) -> Iterator[Row]:
    """What each further relay adds."""
    one, many = relays(core, bench, side, 1), relays(core, bench, side, count)
    row: Row = {"part": "relays", "side": side, "relays": count, "whole": many["p50"], "whole99": many["p99"]}
    yield row | {"hop": (many["p50"] - one["p50"]) / (count - 1), "cpu": many["cpu"], "rss": many["rss"]}
