"""By hand, for ten minutes: who reaches whom with each address, ours and stock's mixed; the ground of interop/hosts.md.

    sudo python interop/hosts/combinations.py [WORDS OF A ROW]

Master and publishers are on one host, subscribers on another. Once the publishers' address is odd, once the
subscribers' (these then start first, so that they depend on the master's news). A row shows whether messages came and
calls were answered, ``+`` or ``-``, in the order roscpp, rospy, pyros1 of the publishers; below it what nodes logged.
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "peers"))

from harness import Peer
from hosts import Host, Network
from mixed import ADDRESSES, KINDS, STRING

CALL = "std_srvs/SetBool"


def start(host: Host, uri: str, prefix: str, extra: dict[str, str]) -> list[Peer]:
    """A peer of each kind, started together."""
    with ThreadPoolExecutor(len(KINDS)) as pool:
        return list(pool.map(lambda kind: host.peer(kind, f"{prefix}_{kind}", uri, **extra), KINDS))


def provide(host: Host, uri: str, extra: dict[str, str]) -> list[Peer]:
    """Publishers that also provide a service."""
    talkers = start(host, uri, "talker", extra)
    for talker in talkers:
        talker.advertise(f"/t_{talker.kind}", STRING, latch=True)
        talker.publish(f"/t_{talker.kind}")
        talker.serve(f"/s_{talker.kind}", CALL)
    return talkers


def ask(host: Host, uri: str, extra: dict[str, str]) -> list[Peer]:
    """Subscribers of all topics."""
    listeners = start(host, uri, "listener", extra)
    for listener in listeners:
        for kind in KINDS:
            listener.subscribe(f"/t_{kind}", STRING)
    return listeners


def heard(listener: Peer) -> str:
    """Whose messages came."""
    signs = ""
    for kind in KINDS:
        try:
            listener.received(f"/t_{kind}", timeout=7)
            signs += "+"
        except AssertionError:
            signs += "-"
    return signs


def answered(listener: Peer) -> str:
    """Whose services answered."""
    signs = ""
    for kind in KINDS:
        listener.tell("call", f"/s_{kind}", CALL, 1, 0)
        signs += "+" if listener.wait_line("^(answer|failed|error|timeout)", 60)[1] == "answer" else "-"
    return signs


def measure(row: str, odd_publishers: bool) -> None:
    """Print a row."""
    variables, name = ADDRESSES[row]
    with Network() as network:
        robot, laptop, _ = network.add("robot"), network.add("laptop"), network.add("third")
        robot.core("ours")
        uri = f"http://{robot.address}:11311/"
        odd, other = (robot, laptop) if odd_publishers else (laptop, robot)
        if name == "":
            other.forget(odd.name)
        elif name is not None:
            odd.know({odd.name: name})
        extra = {key: {"ADDRESS": odd.address, "NAME": odd.name}.get(value, value) for key, value in variables.items()}
        if odd_publishers:
            talkers = provide(robot, uri, extra)
            listeners = ask(laptop, uri, {})
        else:
            listeners = ask(laptop, uri, extra)
            talkers = provide(robot, uri, {})
        with ThreadPoolExecutor(len(KINDS)) as pool:
            messages, calls = list(pool.map(heard, listeners)), list(pool.map(answered, listeners))
        print(f"\n{'publishers' if odd_publishers else 'subscribers'}: {row}")
        for listener, came, called in zip(listeners, messages, calls, strict=True):
            print(f"  {listener.kind:7} messages {came} calls {called}")
        for process in (*robot.processes[:1], *talkers, *listeners):
            said = [line for line in process.lines if "WARN" in line or "ERROR" in line or line.startswith("failed")]
            for line in dict.fromkeys(said):
                print(f"    {process.label}: {line}")


if __name__ == "__main__":
    wanted = " ".join(sys.argv[1:])
    for each in ADDRESSES:
        if wanted in each:
            measure(each, odd_publishers=True)
            measure(each, odd_publishers=False)
