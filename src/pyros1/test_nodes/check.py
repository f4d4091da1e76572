"""What the test nodes share: their cases, how a case fails, and what becomes of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.errors import Error
from pyros1.launch.testing.junit import Case

if TYPE_CHECKING:
    from pyros1.node import Node

Test = Callable[[], None]
"""One test case: raises FailedError if the system is not as it should be."""
CLOCK_PATIENCE = 10.0
"""Seconds of wall time that a simulation gets for its first tick."""
STEP = 0.05
"""Seconds between two looks at the system."""


class FailedError(Error):
    """The system is not as a test expects it."""


class SetupError(Error):
    """A test node was not told what to test; it writes no results then."""


def require(holds: object, text: str) -> None:
    """Fail a test.

    Args:
        holds: what should be true.
        text: said if it is not.

    Raises:
        FailedError: it is not.
    """
    if not holds:
        raise FailedError(text)


def needed(node: Node, *names: str) -> list[Any]:
    """Return the values of private parameters.

    Raises:
        FailedError: one of them is not set.
    """
    missing = [name for name in names if f"~{name}" not in node.params]
    require(not missing, f"not set: {', '.join(node.resolve(f'~{name}') for name in missing)}")
    return [node.params[f"~{name}"] for name in names]


def entries(node: Node, name: str, defaults: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the list of dicts that a private parameter holds, each with a ``name``.

    Args:
        node: whose parameter.
        name: of the parameter; an empty list if it is not set.
        defaults: of the keys that an entry does not have.

    Raises:
        SetupError: it is something else.
    """
    value = node.params.get(f"~{name}", [])
    if not isinstance(value, list) or not all(isinstance(entry, dict) and "name" in entry for entry in value):
        raise SetupError(f"{node.resolve(f'~{name}')} must be a list as [{{name: NAME, timeout: SECONDS}}]: {value!r}")
    return [{**defaults, **entry} for entry in value]


def pause(node: Node, seconds: float) -> None:
    """Wait in wall time.

    Raises:
        Error: the node is told to end meanwhile: nothing is known then.
    """
    ends = time.monotonic() + seconds
    while (left := ends - time.monotonic()) > 0 and node.ok():
        time.sleep(min(left, STEP))
    if not node.ok():
        raise Error("the test was interrupted")


def await_clock(node: Node) -> None:
    """Wait until simulated time runs, if /use_sim_time says that there is such.

    Raises:
        FailedError: it does not.
    """
    ends = time.monotonic() + CLOCK_PATIENCE
    while node.params.get("/use_sim_time", False) and node.now().is_zero():
        require(time.monotonic() < ends, f"/use_sim_time is set, but /clock did not tick for {CLOCK_PATIENCE:g} s")
        pause(node, STEP)


def run_case(name: str, classname: str, test: Test) -> Case:
    """Run a test case.

    Args:
        name: of the case.
        classname: what it is filed under.
        test: the case itself.

    Returns:
        What became of it: a failure if the system is not as it should be, an error if that could not be found out.
    """
    case = Case(name, classname)
    began = time.monotonic()
    try:
        test()
    except FailedError as error:
        case.failures.append(("AssertionError", str(error)))
    except Exception as error:  # noqa: BLE001 - parameters may hold anything, and the other cases count, too
        case.errors.append((type(error).__name__, str(error)))
    case.seconds = time.monotonic() - began
    return case
