"""Shared code of the tf commands: their nodes, and hints after a failed lookup."""

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

TOPICS = ("/tf", "/tf_static")
_MAX_FRAMES_SHOWN = 30


def open_node(invocation: Invocation, name: str, *, tool: bool = True, anonymous: bool = True) -> Node:
    """Return a node.

    Args:
        name: its name.
        anonymous: append a number, so that several can run.
        tool: the node belongs to an interactive tool: fail immediately without a master, and log little.

    Raises:
        MasterUnreachableError: no master answers, and `tool` is set.
    """
    if tool:
        invocation.master.ping()  # fails early, before slow imports, if no master answers
    from pyros1.node import Node  # noqa: PLC0415 - not needed for help

    return Node(
        name,
        anonymous=anonymous,
        argv=invocation.remapping_args,
        environ=invocation.environ,
        rosout=not tool,
        wait_for_master=0.0 if tool else None,
        log_level="warn" if tool else "info",
    )


def make_pause(node: Node) -> Callable[[float], bool]:
    """Return a function that waits a number of seconds of wall time, and returns whether the node is still running."""
    ended = Event()
    node.on_shutdown(ended.set)
    return lambda seconds: not ended.wait(seconds)


def wait_for_clock(node: Node) -> None:
    """If the node uses simulated time, wait a moment for it to start. Print a warning if it does not."""
    pause = make_pause(node)
    for _ in range(20):
        if not node.now().is_zero() or not pause(0.1):
            return
    print(
        "Simulated time is active (/use_sim_time), but no /clock messages arrive: nothing will be shown until they do",
        file=sys.stderr,
        flush=True,
    )


def number(text: str, what: str, *, positive: bool = False) -> float:
    """Return a word as a number.

    Args:
        what: its name, for the error.

    Raises:
        UsageError: it is not a number, or not in the range.
    """
    try:
        value = float(text)
        if value - value != 0 or (positive and value <= 0):
            raise ValueError
    except ValueError:
        raise UsageError(f"{what} must be a {'positive ' if positive else ''}number, not {text!r}") from None
    return value


class LookupHints:
    """Prints to stderr what to do about a failed lookup, once for each reason.

    Args:
        invocation: gives access to the master.
        node: the node that listens.
        buffer: the node's buffer.
    """

    def __init__(self, invocation: Invocation, node: Node, buffer: Buffer) -> None:
        self._invocation = invocation
        self._node = node
        self._buffer = buffer
        self._last_hint = ""

    def print_hint(self, error: TransformException | None, *frames: str) -> None:
        """Print a hint, unless it is the same as the last one.

        Args:
            error: why the lookup failed.
            frames: the frames of the lookup.
        """
        text = self._hint(error, frames)
        if text and text != self._last_hint:
            self._last_hint = text
            sys.stdout.flush()
            print(text, file=sys.stderr, flush=True)

    def _hint(self, error: TransformException | None, frames: tuple[str, ...]) -> str:
        known = sorted(self._buffer.frames())
        if not known:
            return self._no_transforms_hint([self._node.resolve(topic) for topic in TOPICS])
        for frame in frames:
            if frame not in known:
                names = ", ".join(known[:_MAX_FRAMES_SHOWN]) + (
                    f" and {len(known) - _MAX_FRAMES_SHOWN} more" if len(known) > _MAX_FRAMES_SHOWN else ""
                )
                return f"Unknown frame '{frame}'{did_you_mean(frame, known)}; known frames: {names}"
        if isinstance(error, ConnectivityException):
            roots = " and ".join(repr(self._root(frame)) for frame in frames)
            return (
                f"They are in separate trees, with the roots {roots}: no node publishes a transform between the trees"
            )
        return ""

    def _no_transforms_hint(self, topics: list[str]) -> str:
        """Return why no transform has been received."""
        try:
            publishers = self._invocation.graph.state().publishers
        except MasterError:
            return ""
        senders = sorted({name for topic in topics for name in publishers.get(topic, [])})
        if not senders:
            return f"No node publishes {' or '.join(topics)}: is the node running that should? (pyros1 node list)"
        return f"No transform received yet from {', '.join(senders)}: is it running? (pyros1 node ping {senders[0]})"

    def _root(self, frame: str) -> str:
        parents = {state.name: state.parent for state in self._buffer.states()}
        for _ in parents:
            parent = parents.get(frame)
            if parent is None:
                break
            frame = parent
        return frame
