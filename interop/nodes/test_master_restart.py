"""A core that is killed and started again: stock's nodes and ours go on as if nothing had happened.

Feature: a core that is killed and started again carries on -- stock nodes notice nothing; dead nodes are forgotten
"""

from __future__ import annotations

import itertools
import signal
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import Master, free_port, until

from pyros1.master.journal import read_journal

KINDS = ("roscpp", "rospy", "pyros1")
TYPE = "std_msgs/String"


@pytest.fixture
def core(tmp_path: Path) -> Iterator[Master]:
    """A core of this test, which may be killed."""
    master = Master("ours", tmp_path / "home", free_port())
    master.start()
    yield master
    master.close()


def kill(core: Master) -> None:
    """Kill the core, as nothing but the system can.

    It is killed when its journal is complete: a thread of its own writes it, some milliseconds after the answers.
    """
    (path,) = (core.home / "pyros1").glob("*.journal")
    marker = str(uuid.uuid4())
    core.call("setParam", "/marker", marker)
    until(lambda: (journal := read_journal(path)) and marker in str(journal.calls), "the journal has all changes")
    core.core[0].signal(signal.SIGKILL)
    core.core[0].wait()
    core.stop()


@pytest.mark.parametrize(("old", "new"), list(itertools.product(KINDS, KINDS)))
def test_old_links_stay_and_new_nodes_find_old_ones(core: Master, old: str, new: str) -> None:
    sender, receiver = core.ready_peer(old, "sender"), core.ready_peer(old, "receiver")
    sender.advertise("/chat", TYPE)
    receiver.subscribe("/chat", TYPE)
    receiver.subscribe("/back", TYPE)
    sender.linked("/chat")
    receiver.linked("/chat")
    sender.serve("/service", "std_srvs/SetBool")
    core.call("setParam", "/gains", {"p": 1.5, "list": [1, "two"]})
    run_id = core.call("getParam", "/run_id")[2]
    before = [sender.publish("/chat", seed) for seed in (1, 2)]
    kill(core)
    between = [sender.publish("/chat", seed) for seed in (3, 4)]
    core.start()
    assert core.call("getParam", "/gains")[2] == {"p": 1.5, "list": [1, "two"]}
    assert core.call("getParam", "/run_id")[2] == run_id
    assert core.publishers("/chat") == [sender.name] and core.subscribers("/chat") == [receiver.name]
    after = [sender.publish("/chat", seed) for seed in (5, 6)]
    assert [receiver.received("/chat") for _ in range(6)] == before + between + after
    late = core.ready_peer(new, "late")
    late.subscribe("/chat", TYPE)
    sender.linked("/chat", 2)
    late.linked("/chat")
    assert sender.publish("/chat", 7) == late.received("/chat")
    late.available("/service")
    late.call("/service", "std_srvs/SetBool")
    late.advertise("/back", TYPE)
    late.linked("/back")
    assert late.publish("/back", 8) == receiver.received("/back")


@pytest.mark.parametrize("kind", KINDS)
def test_what_died_meanwhile_is_forgotten_and_others_are_told(core: Master, kind: str) -> None:
    sender, receiver = core.ready_peer(kind, "sender"), core.ready_peer("rospy", "receiver")
    sender.advertise("/chat", TYPE)
    receiver.subscribe("/chat", TYPE)
    receiver.linked("/chat")
    kill(core)
    sender.signal(signal.SIGKILL)
    sender.wait()
    core.start()
    until(lambda: not core.publishers("/chat"), "the dead node is forgotten")
    assert core.subscribers("/chat") == [receiver.name]
    again = core.ready_peer(kind, "sender")
    again.advertise("/chat", TYPE)
    again.linked("/chat")
    assert again.publish("/chat", 1) == receiver.received("/chat")


def test_killed_again_and_again_while_nodes_come_and_go(core: Master) -> None:
    keeper = core.ready_peer("roscpp", "keeper")
    keeper.subscribe("/chat", TYPE)
    for number in range(5):
        guest = core.ready_peer("pyros1", f"guest{number}")
        guest.advertise("/chat", TYPE)
        guest.linked("/chat")
        assert guest.publish("/chat", number + 1) == keeper.received("/chat")
        kill(core)
        if number % 2:
            guest.signal(signal.SIGKILL)
            guest.wait()
        core.start()
    until(lambda: core.publishers("/chat") == ["/guest0", "/guest2", "/guest4"], "only the living are known")
    assert core.subscribers("/chat") == ["/keeper"]


def test_a_core_that_ends_by_itself_leaves_nothing(core: Master) -> None:
    core.call("setParam", "/x", 1)
    core.stop()
    core.start()
    assert core.call("getParam", "/x")[0] == -1
    kill(core)
    core.home.joinpath("pyros1").rename(core.home / "elsewhere")
    core.start()
    assert core.call("hasParam", "/x")[2] is False
