"""Formats all frames of a tree as tf2 does: as plain text, as YAML, and in Graphviz's dot language."""

from __future__ import annotations

from collections.abc import Collection

from pyros1.ground.terminal_text import one_line
from pyros1.tf.frame import Frame, to_sec


def as_string(frames: Collection[Frame]) -> str:
    """Return a string with one line per frame, in the order in which the frames were added."""
    lines = []
    for frame in frames:
        if frame.static is not None:
            parent = frame.parent
            parent_name = one_line(parent.name) if parent else "NO_PARENT"
            lines.append(f"Frame {one_line(frame.name)} exists with parent {parent_name}.\n")
    return "".join(lines)


def as_yaml(frames: Collection[Frame], now: float | None = None) -> str:
    """Return parent, broadcaster, rate and times of each frame as YAML.

    Args:
        now: the time in seconds, for the ages of the transforms; None for no ages.
    """
    if not frames:
        return "{}"
    parts = []
    for frame in frames:
        parent = frame.parent
        if parent is None:
            continue
        latest, oldest = to_sec(frame.latest), to_sec(frame.oldest)
        parts.append(
            f"{frame.name}: \n  parent: '{parent.name}'\n  broadcaster: '{frame.authority}'\n"
            f"  rate: {frame.tf2_rate:.3f}\n  most_recent_transform: {latest:.3f}\n  oldest_transform: {oldest:.3f}\n"
        )
        if now:
            parts.append(f"  transform_delay: {now - latest:.3f}\n")
        parts.append(f"  buffer_length: {latest - oldest:.3f}\n")
    return "".join(parts)


def as_dot(frames: Collection[Frame], now: float | None = None) -> str:
    """Return the tree as a graph in Graphviz's dot language, with tf2's labels.

    Args:
        now: the time in seconds, for the ages of the transforms and a legend; None for neither.
    """
    if not frames:
        return 'digraph G {\n"no tf data recieved"}'
    lines = ["digraph G {"]
    for frame in frames:
        parent = frame.parent
        if parent is None:
            continue
        latest = to_sec(frame.latest)
        age = f"( {now - latest:.3f} sec old)" if now else ""
        names = [_escape_label(name) for name in (parent.name, frame.name, frame.authority)]
        lines.append(
            f'"{names[0]}" -> "{names[1]}"[label="Broadcaster: {names[2]}\\n'
            f"Average rate: {frame.tf2_rate:.3f} Hz\\nMost recent transform: {latest:.3f} {age}\\n"
            f'Buffer length: {latest - to_sec(frame.oldest):.3f} sec\\n"];'
        )
    if now:
        lines.append("edge [style=invis];")
        lines += [
            ' subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";\n'
            f'"Recorded at time: {now:.3f}"[ shape=plaintext ] ;\n }}->"{_escape_label(frame.name)}";'
            for frame in frames
            if frame.parent is None
        ]
    return "\n".join([*lines, "}"])


def _escape_label(name: str) -> str:
    return name.replace("\\", "\\\\").replace('"', '\\"')
