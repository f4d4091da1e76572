"""Priorities and timeouts of cmd_vel_mux, and its configuration."""

from __future__ import annotations

import random

import pytest

from pyros1.ground.errors import Error
from pyros1.robot_nodes.shared.twist_sources import Source
from pyros1.robot_nodes.yocs_cmd_vel_mux.config import Config, read_config
from pyros1.robot_nodes.yocs_cmd_vel_mux.selector import Selector

MUX = """
subscribers:
  - name:        "Safe reactive controller"
    topic:       "input/safety_controller"
    timeout:     0.2
    priority:    10
  - {name: "Teleoperation", topic: "input/teleop", timeout: 1, priority: 7, short_desc: "by hand"}
"""
SOURCES = [
    Source("Safe reactive controller", "input/safety_controller", 0.2, 10),
    Source("Teleoperation", "input/teleop", 1.0, 7),
]


def test_configuration() -> None:
    assert read_config(MUX, "mux.yaml") == Config(SOURCES, "output")
    assert read_config(MUX + "publisher: output/cmd_vel", "mux.yaml").output == "output/cmd_vel"
    assert read_config(MUX.replace("timeout: 1,", "timeout: 1e0,"), "mux.yaml") == Config(SOURCES, "output")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "mux.yaml needs a list of subscribers"),
        ("[1, 2]", "mux.yaml needs a list of subscribers"),
        ("subscribers: 3", "mux.yaml: subscribers must be a list, not 3"),
        ("subscribers: [{name: a, topic: b, timeout: 1}]", r"mux.yaml: subscribers\[0\] \(a\) needs a priority"),
        ("{subscribers: [], publisher: 4}", "mux.yaml: publisher must be a topic, not 4"),
        ("subscribers: [", "mux.yaml:1"),
    ],
)
def test_configurations_that_cannot_be_used(text: str, problem: str) -> None:
    with pytest.raises(Error, match=problem):
        read_config(text, "mux.yaml")


def test_taking_over() -> None:
    mux = Selector([Source("Safety", "", 0.25, 10), Source("Teleoperation", "", 1.0, 7)])
    assert mux.active == "idle" and mux.command(1, 0.0) and mux.active == "Teleoperation"
    assert mux.command(0, 0.5) and mux.active == "Safety" and not mux.command(1, 0.625)
    assert not mux.must_stop(0.74) and mux.must_stop(0.75) and not mux.must_stop(0.75) and mux.active == "idle"
    assert mux.command(1, 0.75) and not mux.must_stop(1.7) and mux.must_stop(1.75)


def test_after_time_has_jumped_back() -> None:
    mux = Selector(SOURCES)
    assert mux.command(0, 100.0) and mux.must_stop(5.0) and mux.command(1, 5.0)


def test_random_schedules() -> None:
    """Beside timers that count down at each tick, as stock describes it."""
    chance = random.Random(7)
    stops = 0
    for _ in range(300):
        sources = [Source(str(index), "", chance.choice([1, 2, 5]), chance.choice([0, 1, 1, 9])) for index in range(3)]
        mux = Selector(sources)
        active, timer = None, 0.0
        for now in range(40):
            if active is not None:
                timer -= 1
                if timer == 0:
                    active = None
                    if chance.random() < 0.5:
                        assert mux.must_stop(now)
                        stops += 1
                else:
                    assert not mux.must_stop(now)
            for source in chance.sample(range(3), chance.choice([0, 0, 0, 1, 2])):
                passed = active in (None, source) or sources[source].priority > sources[int(str(active))].priority
                assert mux.command(source, now) == passed
                if passed:
                    active, timer = source, sources[source].timeout
            assert mux.active == str(active) or active is None
    assert stops > 100
