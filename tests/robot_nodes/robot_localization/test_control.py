from __future__ import annotations

import numpy as np
import pytest

from pyros1.robot_nodes.robot_localization.control import Control
from pyros1.robot_nodes.robot_localization.ekf import Ekf
from pyros1.robot_nodes.robot_localization.motion import SIZE

SECOND = 10**9


def make_control(command: list[float]) -> Control:
    return Control(
        used=np.array([True, False, False, False, False, True]),
        acceleration_limits=np.full(6, 1.0),
        deceleration_limits=np.full(6, 3.0),
        acceleration_gains=np.full(6, 2.0),
        deceleration_gains=np.full(6, 4.0),
        timeout=0.5,
        command=np.array(command),
        time=10 * SECOND,
    )


@pytest.mark.parametrize(
    ("command", "velocity", "expected"),
    [
        (2.0, 0.0, 1.0),  # limited
        (0.3, 0.0, 0.6),  # gain 2
        (-2.0, 0.0, -1.0),
        (0.0, 2.0, -3.0),  # brakes
        (0.5, 1.0, -2.0),  # gain 4
        (-0.5, 0.3, -3.0),  # the other way: brakes first
        (1.0, 1.0, 0.0),
    ],
)
def test_the_robot_accelerates_towards_the_command(command: float, velocity: float, expected: float) -> None:
    control = make_control([command, command, 0.0, 0.0, 0.0, command])
    found = control.accelerations(np.array([velocity, velocity, 0.0, 0.0, 0.0, velocity]), 10 * SECOND)
    assert found == pytest.approx([expected, 0.0, 0.0, 0.0, 0.0, expected])


def test_without_commands_the_robot_stops() -> None:
    control, velocity = make_control([1.0, 0, 0, 0, 0, 0]), np.array([1.0, 0, 0, 0, 0, 0])
    assert control.accelerations(velocity, 10 * SECOND + SECOND // 4)[0] == 0.0
    assert control.accelerations(velocity, 11 * SECOND)[0] == -3.0


def test_the_filter_follows_the_command() -> None:
    ekf, control = Ekf(np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))), make_control([1.0, 0, 0, 0, 0, 0.5])
    control.timeout = 100.0
    ekf.state[13] = 0.25  # an acceleration that is not commanded stays
    for step in range(500):
        ekf.predict(0.01, control, 10 * SECOND + step)
    assert ekf.state[[6, 11]] == pytest.approx([1.0, 0.5], abs=1e-3)
    assert ekf.state[13] == 0.25
