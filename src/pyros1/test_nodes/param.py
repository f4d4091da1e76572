"""paramtest checks that a parameter is set, and that it has the expected value."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from pyros1.test_nodes.common import POLL_INTERVAL, Test, pause, require, required_params

if TYPE_CHECKING:
    from pyros1.node import Node

_DEFAULT_DURATION = 5.0
_DEFAULT_WAIT_TIME = 20.0


def tests(node: Node) -> dict[str, Test]:
    """Return the test cases of paramtest, by name.

    Args:
        node: the node; its parameters are ~param_name_target, ~param_value_expected, ~test_duration and ~wait_time.
    """
    return {"test_param": lambda: _test_param(node)}


def _test_param(node: Node) -> None:
    (name,) = required_params(node, "param_name_target")
    expected = node.params.get("~param_value_expected")
    duration = float(node.params.get("~test_duration", _DEFAULT_DURATION))
    timeout = float(node.params.get("~wait_time", _DEFAULT_WAIT_TIME))
    node.log.info(f"waiting up to {timeout:g} s for {name}")
    require(duration > 0, f"~test_duration must be greater than 0: {duration}")
    require(name, "~param_name_target is empty")
    value = None
    deadline = time.monotonic() + timeout
    while value is None and time.monotonic() < deadline:
        value = node.params.get(name)
        if value is None:
            pause(node, POLL_INTERVAL)
    require(value is not None, f"{node.resolve(name)} was not set within {timeout:g} s")
    # As in stock ROS, if the expected value is 0, False or empty, any value is accepted.
    require(not expected or value == expected, f"{node.resolve(name)} should be {expected!r}, but is {value!r}")
