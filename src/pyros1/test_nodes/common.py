"""Code shared by the test nodes: runs test cases, checks conditions, reads parameters, and waits for the clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error
from pyros1.launch.testing.junit import Case

if TYPE_CHECKING:
    from pyros1.node import Node

Test = Callable[[], None]
"""A test case; raises FailedError if the system does not meet the expectations."""
CLOCK_TIMEOUT = 10.0
"""Maximum number of seconds of wall time to wait for the first message on /clock."""
POLL_INTERVAL = 0.05
"""Seconds between checks of the system."""


class FailedError(Error):
    """The system does not meet the expectations of a test."""


class SetupError(Error):
    """A test node has nothing to test, so it writes no results."""


def require(condition: object, message: str) -> None:
    """Fail the test unless a condition is true.

    Args:
        condition: true if the test may continue.
        message: the error message.

    Raises:
        FailedError: the condition is false.
    """
    if not condition:
        raise FailedError(message)


def required_params(node: Node, *names: str) -> list[Any]:
    """Return the values of private parameters.

    Raises:
        FailedError: at least one of the parameters is not set.
    """
    missing = [name for name in names if f"~{name}" not in node.params]
    require(not missing, f"not set: {', '.join(node.resolve(f'~{name}') for name in missing)}")
    return [node.params[f"~{name}"] for name in names]


def list_param(node: Node, name: str, defaults: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the value of a private parameter, which is a list of dictionaries, each with a ``name``.

    Args:
        node: the node.
        name: the parameter's name. If the parameter is not set, the list is empty.
        defaults: values for the keys that an entry does not have.

    Raises:
        SetupError: the value is not a list of such dictionaries.
    """
    value = node.params.get(f"~{name}", [])
    if not isinstance(value, list) or not all(isinstance(entry, dict) and "name" in entry for entry in value):
        raise SetupError(
            f"{node.resolve(f'~{name}')} must be a list like [{{name: NAME, timeout: SECONDS}}], not {value!r}"
        )
    return [{**defaults, **entry} for entry in value]


def pause(node: Node, seconds: float) -> None:
    """Sleep for a number of seconds of wall time, or until the node is shut down.

    Raises:
        Error: the node was shut down, so that the test has no result.
    """
    deadline = time.monotonic() + seconds
    while (remaining := deadline - time.monotonic()) > 0 and node.ok():
        time.sleep(min(remaining, POLL_INTERVAL))
    if not node.ok():
        raise Error("the test was interrupted")


def wait_for_clock(node: Node) -> None:
    """Wait until simulated time has started, if /use_sim_time is set.

    Raises:
        FailedError: no message arrives on /clock in time.
    """
    deadline = time.monotonic() + CLOCK_TIMEOUT
    while node.params.get("/use_sim_time", False) and node.now().is_zero():
        require(
            time.monotonic() < deadline,
            f"/use_sim_time is set, but no message arrived on /clock within {CLOCK_TIMEOUT:g} s",
        )
        pause(node, POLL_INTERVAL)


def run_case(name: str, classname: str, test: Test) -> Case:
    """Run a test case.

    Args:
        name: name of the test case.
        classname: class name of the test case in the results.
        test: the test case.

    Returns:
        The result: a failure if the system does not meet the expectations, an error if the test case raised another
            exception.
    """
    case = Case(name, classname)
    start = time.monotonic()
    try:
        test()
    except FailedError as error:
        case.failures.append(("AssertionError", str(error)))
    except Exception as error:  # noqa: BLE001 - parameters may have any value, and the other cases must still run
        case.errors.append((type(error).__name__, str(error)))
    case.seconds = time.monotonic() - start
    return case
