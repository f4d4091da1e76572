"""rostest, by pyros1: tests in a running system (https://wiki.ros.org/rostest)."""

from __future__ import annotations

import functools
import subprocess
import sys
import warnings
from collections.abc import Callable
from typing import Any
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
import rosunit
from rosunit import XML_OUTPUT_FLAG
from rosunit.pyunit import run_suite

__all__ = [
    "XML_OUTPUT_FLAG",
    "deprecated",
    "get_master",
    "is_publisher",
    "is_subscriber",
    "rosrun",
    "rostestmain",
    "run",
    "unitrun",
]


def get_master() -> ServerProxy:
    """Return an ``xmlrpc.client.ServerProxy`` for the master."""
    return ServerProxy(rosgraph.get_master_uri())


def _is_registered(index: int, topic: str, node: str) -> bool:
    master: Any = get_master()
    code, message, state = master.getSystemState("/roslib")
    if code != 1:
        raise OSError(f"Unable to retrieve master state: {message}")
    return any(node in nodes for name, nodes in state[index] if name == topic)


def is_publisher(topic: str, publisher_id: str) -> bool:
    """Return whether a node publishes a topic, according to the master; both names must be fully resolved.

    Raises:
        IOError: the master does not respond.
    """
    return _is_registered(0, topic, publisher_id)


def is_subscriber(topic: str, subscriber_id: str) -> bool:
    """Return whether a node subscribes to a topic; see `is_publisher`."""
    return _is_registered(1, topic, subscriber_id)


def rosrun(package: str, test_name: str, test: Any, sysargs: list[str] | None = None) -> None:
    """Run tests, shut down this program's node, and exit with 1 if a test failed; called at the end of a test program.

    Args:
        package: the ROS package.
        test_name: name of the results.
        test: a class of tests, or the name of a class or module.
        sysargs: the command line, with ``--text`` or ``--gtest_output=xml:FILE``; None for the program's.
    """
    result = run_suite(package, test_name, test, sys.argv if sysargs is None else sysargs)
    rospy.signal_shutdown("test complete")
    if not result.wasSuccessful():
        sys.exit(1)


run = rosrun


def deprecated(func: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a function so that calls cause a DeprecationWarning."""

    @functools.wraps(func)
    def warn_and_call(*args: Any, **kwargs: Any) -> Any:
        warnings.warn(f"Call to deprecated function {func.__name__}.", DeprecationWarning, stacklevel=2)
        return func(*args, **kwargs)

    return warn_and_call


@deprecated
def unitrun(
    package: str,
    test_name: str,
    test: Any,
    sysargs: list[str] | None = None,
    coverage_packages: list[str] | None = None,
) -> None:
    """The old name of `rosunit.unitrun`."""
    rosunit.unitrun(package, test_name, test, sysargs=sysargs, coverage_packages=coverage_packages)


def rostestmain() -> None:
    """Run the tests of launch files, as ``pyros1 test`` does."""
    sys.exit(subprocess.call([sys.executable, "-m", "pyros1", "test", *sys.argv[1:]]))
