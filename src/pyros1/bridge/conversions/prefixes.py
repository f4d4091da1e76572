"""Adds prefixes in received messages: to coordinate frames, if a rule says so, and to nodes in log messages.

Two robots may both have a frame ``base_link`` and a node ``/driver``. At a third site the frames become
``red/base_link`` and ``blue/base_link``, so that both fit into one tf tree, and the nodes ``/red/driver`` and
``/blue/driver``, as their topics appear below ``/red`` and ``/blue``. No I/O.
"""

from __future__ import annotations

from collections.abc import Collection

from pyros1.bridge.conversions.strings_in_messages import Change, StringChanger
from pyros1.ground.errors import Error, MessageError
from pyros1.msgs import from_definition

_FRAME_FIELDS = ("frame_id", "child_frame_id")
"""Fields with frame names: in std_msgs/Header and geometry_msgs/TransformStamped, and in other types by convention."""
_LOG = "rosgraph_msgs/Log"


def frame_prefixer(prefix: str, kept: Collection[str]) -> Change:
    """Return a function that prefixes the name of a frame. An empty name stays empty.

    Args:
        prefix: the prefix, without a slash at its end.
        kept: frames that keep their names, such as a shared map.
    """
    begin = prefix.encode() + b"/"
    exceptions = frozenset(name.encode() for name in kept)

    def change(frame: bytes) -> bytes:
        name = frame.lstrip(b"/")  # as tf2 reads it
        return begin + name if name and name not in exceptions else frame

    return change


def node_prefixer(prefix: str) -> Change:
    """Return a function that puts a namespace such as ``/red`` before a node's full name."""
    begin = prefix.encode()
    return lambda node: begin + node if node.startswith(b"/") else begin + b"/" + node


class Prefixer:
    """Adds prefixes to a topic's messages, once its definition is known.

    Args:
        frames: the prefix of frames; empty for none.
        kept_frames: frames that keep their names.
        nodes: the namespace of nodes in log messages; empty for none.
    """

    def __init__(self, frames: str, kept_frames: Collection[str], nodes: str) -> None:
        self._frame_changes: dict[str, Change] = {}
        if frames:
            self._frame_changes = dict.fromkeys(_FRAME_FIELDS, frame_prefixer(frames, kept_frames))
        self._nodes = nodes
        self._definition: str | None = None
        self._changer: StringChanger | None = None
        self._problem = ""

    def learn(self, type_name: str, definition: str) -> str:
        """Record the definition of the topic's type; return why its messages cannot get prefixes, or "" if they can.

        Args:
            type_name: the type.
            definition: its definition; empty if it cannot be used.
        """
        if definition != self._definition:
            self._definition = definition
            try:
                self._changer, self._problem = self._make_changer(type_name, definition), ""
            except Error as error:
                self._changer, self._problem = None, f"prefixes cannot be added: {error}"
        return self._problem

    def _make_changer(self, type_name: str, definition: str) -> StringChanger | None:
        changes = dict(self._frame_changes)
        if self._nodes and type_name == _LOG:
            changes["name"] = node_prefixer(self._nodes)
        if not changes or not (definition or self._frame_changes):
            return None
        if not definition:
            raise MessageError("the definition of its type is not known")
        changer = StringChanger(from_definition(type_name, definition), changes)
        return changer if changer.is_useful else None

    def change(self, body: bytes) -> bytes:
        """Return a message with the prefixes added.

        Raises:
            MessageError: it is not a message of its type.
        """
        return body if self._changer is None else self._changer.change(body)
