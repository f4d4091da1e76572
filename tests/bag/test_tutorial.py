"""The tutorial's scene: record topic1 of the minimal nodes, stop them, play the file to minimal_subscriber.

Feature: record, stop, play -- the minimal nodes' topic1
"""

from __future__ import annotations

import re
import signal
import time
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.bag.format.reader import BagReader
from pyros1.msgs.std_msgs.msg import Float64

from ..bodies import decode

SCRIPTS = Path(pyros1.__file__).parent / "packages" / "minimal_nodes" / "scripts"
DEADLINE = 20.0


@pytest.mark.slow
def test_what_was_recorded_is_played(start: Any, tmp_path: Path, master: Any) -> None:
    publisher = start("_rate:=20", program=SCRIPTS / "minimal_publisher")
    recorder = start("bag", "record", "-O", "tutorial", "topic1", "--min-space", "0")
    end = time.monotonic() + DEADLINE
    while recorded(tmp_path / "tutorial.bag.active") < 15:
        assert time.monotonic() < end and recorder.poll() is None
        time.sleep(0.1)
    for child in (recorder, publisher):
        child.send_signal(signal.SIGINT)
        _, err = child.communicate(timeout=DEADLINE)
        assert (child.returncode, err) == (0, "")
    with BagReader(tmp_path / "tutorial.bag") as bag:
        values = [decode(Float64, message.data).data for message in bag.messages()]
        length = (bag.end - bag.start) / 1e9
    assert len(values) >= 15

    subscriber = start(program=SCRIPTS / "minimal_subscriber")
    player = start("bag", "play", "--wait-for-subscribers", "tutorial.bag")
    expected = [f"{value:.6f}" for value in values]
    lines = [subscriber.stdout.readline()]
    # It has a queue of one: while the machine is busy, it skips messages, but never the last one.
    while lines[-1] and expected[-1] not in lines[-1]:
        lines.append(subscriber.stdout.readline())
    found = [re.fullmatch(r"\[INFO\] \[(\d+\.\d+)\]: received value is: (\d+\.\d{6})\n", line) for line in lines]
    assert all(found), lines
    rest = iter(expected)
    assert all(match[2] in rest for match in found if match), "they come in order"
    stamps = [float(match[1]) for match in found if match]
    assert stamps[-1] - stamps[0] > length / 2, "at the pace of the recording, not at once"
    assert player.communicate(timeout=DEADLINE)[1] == "" and player.returncode == 0
    subscriber.send_signal(signal.SIGINT)


def recorded(path: Path) -> int:
    """The number of messages that a recording has brought to the disk so far."""
    try:
        with BagReader(path, unindexed=True) as bag:
            return bag.count()
    except (OSError, pyros1.ground.errors.Error):
        return 0
