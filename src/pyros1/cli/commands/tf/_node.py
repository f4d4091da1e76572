"""Shared code of the verbs of ``tf``: nodes, waiting, numbers in arguments, and hints after failed lookups."""

from __future__ import annotations

import sys
from collections.abc import Callable
from threading import Event
from typing import TYPE_CHECKING

from pyros1.cli.failures import UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.ground.errors import MasterError
from pyros1.tf.errors import ConnectivityException, TransformException

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.tf.buffer import Buffer

TF_TOPICS = ("/tf", "/tf_static")
_MAX_FRAMES_SHOWN = 30


def open_node(invocation: Invocation, name: str, *, is_tool: bool = True, anonymous: bool = True) -> Node:
    """Create and return the node of a tf command.

    Args:
        invocation: the command's invocation.
        name: the node's name.
        is_tool: whether the node belongs to an interactive tool, which fails immediately without a master, and logs
            little.
        anonymous: whether to append a number to the name, so that the command can run several times.

    Raises:
        MasterUnreachableError: no master is running, and `is_tool` is True.
    """
    if is_tool:
        invocation.master.ping()  # fail before slow imports if no master is running
    from pyros1.node import Node  # noqa: PLC0415 - not needed for help

    return Node(
        name,
        anonymous=anonymous,
        argv=invocation.remapping_args,
        environ=invocation.environ,
        rosout=not is_tool,
        wait_for_master=0.0 if is_tool else None,
        log_level="warn" if is_tool else "info",
    )


def make_pause(node: Node) -> Callable[[float], bool]:
    """Return a function that waits for a number of wall-clock seconds and returns whether the node is still running."""
    has_shut_down = Event()
    node.on_shutdown(has_shut_down.set)
    return lambda seconds: not has_shut_down.wait(seconds)


def wait_for_clock(node: Node) -> None:
    """If the node uses simulated time, wait up to two seconds for the first time. Print a warning if none arrives."""
    pause = make_pause(node)
    for _ in range(20):
        if not node.now().is_zero() or not pause(0.1):
            return
    print(
        "Simulated time is active (/use_sim_time), but no /clock messages arrive: nothing is printed until they do",
        file=sys.stderr,
        flush=True,
    )


def parse_number(text: str, value_name: str, *, positive: bool = False) -> float:
    """Parse an argument that must be a number.

    Args:
        text: the argument.
        value_name: the name of the value, for the error message.
        positive: whether the number must be positive.

    Raises:
        UsageError: the argument is not a number or not in the allowed range.
    """
    try:
        value = float(text)
        if value - value != 0 or (positive and value <= 0):
            raise ValueError
    except ValueError:
        raise UsageError(f"{value_name} must be a {'positive ' if positive else ''}number, not {text!r}") from None
    return value


class LookupHints:
    """Prints hints about failed lookups to stderr, but never the same hint twice in a row.

    Args:
        invocation: the command's invocation, through which the master is queried.
        node: the node that listens to transforms.
        buffer: the node's buffer.
    """

    def __init__(self, invocation: Invocation, node: Node, buffer: Buffer) -> None:
        self._invocation = invocation
        self._node = node
        self._buffer = buffer
        self._last_hint = ""

    def print_hint(self, error: TransformException | None, *frames: str) -> None:
        """Print a hint about a failed lookup, unless it is the same as the last hint.

        Args:
            error: the lookup's error; None if no lookup was tried.
            frames: the frames of the lookup.
        """
        hint = self._make_hint(error, frames)
        if hint and hint != self._last_hint:
            self._last_hint = hint
            sys.stdout.flush()
            print(hint, file=sys.stderr, flush=True)

    def _make_hint(self, error: TransformException | None, frames: tuple[str, ...]) -> str:
        known_frames = sorted(self._buffer.frames())
        if not known_frames:
            return self._no_transforms_hint([self._node.resolve(topic) for topic in TF_TOPICS])
        for frame in frames:
            if frame not in known_frames:
                frame_list = ", ".join(known_frames[:_MAX_FRAMES_SHOWN]) + (
                    f" and {len(known_frames) - _MAX_FRAMES_SHOWN} more"
                    if len(known_frames) > _MAX_FRAMES_SHOWN
                    else ""
                )
                return f"Unknown frame '{frame}'{did_you_mean(frame, known_frames)}; known frames: {frame_list}"
        if isinstance(error, ConnectivityException):
            roots = " and ".join(repr(self._find_root(frame)) for frame in frames)
            return (
                f"The frames are in separate trees with the roots {roots}: "
                "no node publishes a transform between the trees"
            )
        return ""

    def _no_transforms_hint(self, topics: list[str]) -> str:
        """Return the probable reason why no transform has been received."""
        try:
            publishers = self._invocation.graph.state().publishers
        except MasterError:
            return ""
        publisher_names = sorted({name for topic in topics for name in publishers.get(topic, [])})
        if not publisher_names:
            return (
                f"No node publishes {' or '.join(topics)}: is the node that should publish running? (pyros1 node list)"
            )
        return (
            f"No transform received yet from {', '.join(publisher_names)}: is it running? "
            f"(pyros1 node ping {publisher_names[0]})"
        )

    def _find_root(self, frame: str) -> str:
        parents = {state.name: state.parent for state in self._buffer.states()}
        for _ in parents:
            parent = parents.get(frame)
            if parent is None:
                break
            frame = parent
        return frame
