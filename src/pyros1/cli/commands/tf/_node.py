"""What the tf commands share: their nodes, and what to tell a user who asked for a frame in vain."""

from __future__ import annotations

import sys
from collections.abc import Callable
from threading import Event
from typing import TYPE_CHECKING

from pyros1.cli.failures import UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.errors import MasterError
from pyros1.tf.errors import ConnectivityException, TransformException

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.tf.buffer import Buffer

TOPICS = ("/tf", "/tf_static")
_MOST = 30


def open_node(invocation: Invocation, name: str, *, tool: bool = True) -> Node:
    """Return a node with an anonymous name.

    Args:
        name: its base name.
        tool: somebody waits for an answer: fail at once without a master, and log little. Else it is a common node.

    Raises:
        MasterUnreachableError: a tool has no master.
    """
    if tool:
        invocation.master.ping()  # says at once, before anything heavy is imported, if there is no master
    from pyros1.node import Node  # noqa: PLC0415 - help needs none

    return Node(
        name,
        anonymous=True,
        argv=invocation.remapping_args,
        environ=invocation.environ,
        rosout=not tool,
        wait_for_master=0.0 if tool else None,
        log_level="warn" if tool else "info",
    )


def pauser(node: Node) -> Callable[[float], bool]:
    """Return a function that waits so many seconds of wall time, and returns whether the node goes on."""
    ended = Event()
    node.on_shutdown(ended.set)
    return lambda seconds: not ended.wait(seconds)


def await_clock(node: Node) -> None:
    """Wait shortly until simulated time runs, if the node's time is simulated; say so if it does not."""
    pause = pauser(node)
    for _ in range(20):
        if not node.now().is_zero() or not pause(0.1):
            return
    print(
        "Simulated time is active (/use_sim_time), but /clock does not tick: nothing will be shown until it does",
        file=sys.stderr,
        flush=True,
    )


def number(text: str, what: str, *, positive: bool = False) -> float:
    """Return the number that a word is.

    Args:
        what: its name, for the error.

    Raises:
        UsageError: it is none.
    """
    try:
        value = float(text)
        if value - value != 0 or (positive and value <= 0):
            raise ValueError
    except ValueError:
        raise UsageError(f"{what} must be a {'positive ' if positive else ''}number, not {text!r}") from None
    return value


class Cures:
    """Says, once for each reason, what may be done about a lookup that failed; on stderr.

    Args:
        invocation: knows the master.
        node: who listens.
        buffer: what it heard.
    """

    def __init__(self, invocation: Invocation, node: Node, buffer: Buffer) -> None:
        self._invocation = invocation
        self._node = node
        self._buffer = buffer
        self._said = ""

    def tell(self, error: TransformException | None, *frames: str) -> None:
        """Print a cure, if there is one and it was not the last one.

        Args:
            error: why the lookup failed.
            frames: the frames that were asked for.
        """
        text = self._cure(error, frames)
        if text and text != self._said:
            self._said = text
            sys.stdout.flush()
            print(text, file=sys.stderr, flush=True)

    def _cure(self, error: TransformException | None, frames: tuple[str, ...]) -> str:
        known = sorted(self._buffer.frames())
        if not known:
            return self._silence([self._node.resolve(topic) for topic in TOPICS])
        for frame in frames:
            if frame not in known:
                names = ", ".join(known[:_MOST]) + (f" and {len(known) - _MOST} more" if len(known) > _MOST else "")
                return f"There is no frame '{frame}'{did_you_mean(frame, known)}; there are: {names}"
        if isinstance(error, ConnectivityException):
            roots = " and ".join(repr(self._root(frame)) for frame in frames)
            return f"The roots of their trees are {roots}: no node publishes where one of these is in the other's tree"
        return ""

    def _silence(self, topics: list[str]) -> str:
        """Why no transform has come."""
        try:
            publishers = self._invocation.graph.state().publishers
        except MasterError:
            return ""
        senders = sorted({name for topic in topics for name in publishers.get(topic, [])})
        if not senders:
            return f"Nothing publishes {' or '.join(topics)}: does the node run that knows them? (pyros1 node list)"
        return f"No transform has come yet from {', '.join(senders)}: do they run? (pyros1 node ping {senders[0]})"

    def _root(self, frame: str) -> str:
        parents = {state.name: state.parent for state in self._buffer.states()}
        for _ in parents:
            above = parents.get(frame)
            if above is None:
                break
            frame = above
        return frame
