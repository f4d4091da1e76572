"""Addresses with which all come: each row of interop/hosts.md that says "came", and hosts whose clocks differ."""

from __future__ import annotations

from pathlib import Path

import pytest
from hosts import Network
from mixed import ADDRESSES, STRING, check_served, peers, provide

GOOD = [
    "neither set",
    "neither set, own name is 127.0.1.1 here",
    "ROS_IP right",
    "ROS_IP right, name unknown elsewhere",
    "ROS_HOSTNAME right",
]
FAKETIME = next(iter(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1")), None)
"""Debian's faketime: host names, networks and processes can be a host's own, clocks cannot. rospy does not run with it:
Python's `time.sleep` fails."""


@pytest.mark.parametrize("odd", ["publishers", "subscribers"])
@pytest.mark.parametrize("row", GOOD)
def test_all_come(row: str, odd: str) -> None:
    """Messages and calls in all nine pairs of roscpp, rospy and pyros1, whichever side has the address."""
    variables, name = ADDRESSES[row]
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        robot.core("ours")
        uri = f"http://{robot.address}:11311/"
        host, other = (robot, laptop) if odd == "publishers" else (laptop, robot)
        if name == "":
            other.forget(host.name)
        elif name is not None:
            host.know({host.name: name})
        extra = {
            key: {"ADDRESS": host.address, "NAME": host.name}.get(value, value) for key, value in variables.items()
        }
        provide(peers(robot, uri, "talker", **(extra if host is robot else {})))
        for listener in peers(laptop, uri, "listener", **(extra if host is laptop else {})):
            check_served(listener)


@pytest.mark.parametrize(("offset", "words"), [("-2h", "7200 s behind"), ("+90", "90 s ahead of")])
def test_a_host_whose_clock_is_wrong(offset: str, words: str) -> None:
    """Topics and services do not care; `wtf` names the host and the difference."""
    assert FAKETIME, "faketime is missing: interop/setup installs it"
    wrong = {"LD_PRELOAD": str(FAKETIME), "FAKETIME": offset, "FAKETIME_DONT_FAKE_MONOTONIC": "1"}
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        uri = robot.core("ours")
        talkers = [robot.peer(kind, f"talker_{kind}", uri, **wrong) for kind in ("roscpp", "pyros1")]
        provide(talkers)
        for kind in ("roscpp", "pyros1"):
            listener = laptop.peer(kind, f"listener_{kind}", uri)
            for talker in talkers:
                listener.subscribe(f"/t_{talker.kind}", STRING)
                listener.received(f"/t_{talker.kind}", timeout=40)
                listener.call(f"/s_{talker.kind}", "std_srvs/SetBool")
        found = laptop.run(laptop.pyros1("wtf"), laptop.environ(uri)).output
        assert "the clock of [robot] is " in found and " ".join(words.split()[2:]) in found, found
        seconds = int(found.partition("the clock of [robot] is ")[2].split()[0])
        assert abs(seconds - int(words.split(maxsplit=1)[0])) <= 2
