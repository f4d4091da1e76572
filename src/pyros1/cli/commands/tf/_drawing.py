"""Draws trees of frames as text, as a Graphviz graph, or as an SVG image."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from pyros1.ground.terminal_text import one_line

LETTER_WIDTH = 7.0  # average width of a letter in pixels
LINE_HEIGHT = 15.0  # height of a line of text in pixels
MARGIN = 14.0
GAP_X, GAP_Y = 18.0, 44.0


class Frame(NamedTuple):
    """A frame to draw, and its transform to the parent.

    Attributes:
        name: the name of the frame.
        parent: the name of the parent; None for the root of a tree.
        authority: the node that publishes the transform.
        static: whether the transform to the parent is static; None if unknown.
        rate: the rate of the transforms in Hz; 0 for a single transform.
        latest, oldest: times of the newest and the oldest transform in seconds.
    """

    name: str
    parent: str | None
    authority: str
    static: bool | None
    rate: float
    latest: float
    oldest: float

    def description(self, now: float) -> list[str]:
        """Return the parts of the transform's description: publisher, rate and age. A root has none."""
        if self.parent is None:
            return []
        if self.static or (self.static is None and not self.latest):
            return [self.authority, "static"]
        rate = f"{self.rate:.1f} Hz" if self.latest > self.oldest else "once"
        return [self.authority, rate, f"{now - self.latest:.3f} s old"]


def find_roots_and_children(frames: Sequence[Frame]) -> tuple[list[Frame], dict[str, list[Frame]]]:
    """Return the root frames and the child frames by parent, both sorted by name.

    Frames in a loop have no root, so the first frame of each loop is used as a root.
    """
    children_by_parent: dict[str, list[Frame]] = {}
    for frame in sorted(frames):
        if frame.parent is not None:
            children_by_parent.setdefault(frame.parent, []).append(frame)
    frame_names = {frame.name for frame in frames}
    roots = [frame for frame in sorted(frames) if frame.parent is None or frame.parent not in frame_names]
    reached: set[str] = set()
    for frame in [*roots, *sorted(frames)]:
        if frame.name in reached:
            continue
        if frame not in roots:  # the frame is in a loop
            roots.append(frame)
            children_by_parent[str(frame.parent)] = [
                child for child in children_by_parent[str(frame.parent)] if child is not frame
            ]
        pending_names = [frame.name]
        while pending_names:
            name = pending_names.pop()
            reached.add(name)
            pending_names += [child.name for child in children_by_parent.get(name, [])]
    return roots, children_by_parent


def format_tree(frames: Sequence[Frame], now: float) -> str:
    """Return the trees as text, with the description of each frame's transform after the frame's name.

    Args:
        frames: the frames.
        now: the current time in seconds, from which ages are computed.
    """
    roots, children_by_parent = find_roots_and_children(frames)
    rows: list[tuple[str, list[str]]] = []

    def add_rows(frame: Frame, prefix: str, child_prefix: str) -> None:
        rows.append((prefix + one_line(frame.name), [*map(one_line, frame.description(now))]))
        last_number = len(children_by_parent.get(frame.name, ())) - 1
        for number, child in enumerate(children_by_parent.get(frame.name, ())):
            is_last = number == last_number
            add_rows(
                child, child_prefix + ("└── " if is_last else "├── "), child_prefix + ("    " if is_last else "│   ")
            )

    for root in roots:
        add_rows(root, "", "")
    width = max((len(name) for name, _ in rows), default=0)
    authority_width = max((len(details[0]) for _, details in rows if details), default=0)
    lines = []
    for name, details in rows:
        line = f"{name:{width}}"
        if details:
            line += f"  {details[0]:{authority_width}}  {details[1]:>9}  {' '.join(details[2:])}"
        lines.append(line.rstrip())
    return "\n".join(lines)


def render_dot(frames: Sequence[Frame], now: float) -> str:
    """Return the trees in the dot language of Graphviz, with the labels of tf2_tools."""
    lines = ["digraph G {"]
    for frame in frames:
        if frame.parent is None:
            continue
        label = (
            f" Broadcaster: {_quote(frame.authority)}\\nAverage rate: {round(frame.rate, 3) or 10000.0}\\n"
            f"Buffer length: {round(frame.latest - frame.oldest, 3)}\\n"
            f"Most recent transform: {round(frame.latest, 3)}\\nOldest transform: {round(frame.oldest, 3)}\\n"
        )
        lines.append(f'"{_quote(frame.parent)}" -> "{_quote(frame.name)}"[label="{label}"];')
    for root in find_roots_and_children(frames)[0]:
        lines += [
            "edge [style=invis];",
            ' subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";',
            f'"Recorded at time: {now}"[ shape=plaintext ] ;',
            f'}}->"{_quote(root.name)}";',
        ]
    return "\n".join([*lines, "}"])


def _quote(name: str) -> str:
    return name.replace("\\", "\\\\").replace('"', '\\"')


class _Box(NamedTuple):
    """The box of a frame. `x` and `y` are the position of the middle of the box's upper edge in pixels."""

    frame: Frame
    lines: list[str]
    x: float
    y: float
    width: float
    height: float


def render_svg(frames: Sequence[Frame], now: float, title: str) -> str:
    """Return the trees as an SVG image. Parents are above their children, and descriptions are below each name.

    Args:
        frames: the frames.
        now: the current time in seconds, from which ages are computed.
        title: the title at the top.
    """
    roots, children_by_parent = find_roots_and_children(frames)
    boxes: dict[str, _Box] = {}
    top = 2 * MARGIN + LINE_HEIGHT

    def place_subtree(frame: Frame, left: float, y: float) -> float:
        """Place the boxes of a frame and its descendants. Return the width that they need in pixels."""
        lines = [frame.name, *frame.description(now)]
        width = max(map(len, lines)) * LETTER_WIDTH + 2 * MARGIN
        height = len(lines) * LINE_HEIGHT + MARGIN
        children = children_by_parent.get(frame.name, [])
        child_widths = []
        child_left = left
        for child in children:
            child_width = place_subtree(child, child_left, y + height + GAP_Y)
            child_widths.append(child_width)
            child_left += child_width + GAP_X
        required_width = max(width, child_left - GAP_X - left) if children else width
        extra_width = (required_width - (child_left - GAP_X - left)) / 2 if children else 0.0
        if extra_width > 0:  # centre the children below a wider frame
            for child in children:
                move_right(child, extra_width)
        boxes[frame.name] = _Box(frame, lines, left + required_width / 2, y, width, height)
        return required_width

    def move_right(frame: Frame, offset: float) -> None:
        box = boxes[frame.name]
        boxes[frame.name] = box._replace(x=box.x + offset)
        for child in children_by_parent.get(frame.name, []):
            move_right(child, offset)

    right = MARGIN
    for root in roots:
        right += place_subtree(root, right, top) + 2 * GAP_X
    width = max(right, len(title) * LETTER_WIDTH + 2 * MARGIN)
    height = max((box.y + box.height for box in boxes.values()), default=top) + MARGIN
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text x="{MARGIN:g}" y="{MARGIN + LINE_HEIGHT / 2:g}" fill="#666">{escape(title)}</text>',
    ]
    for box in boxes.values():
        parent_box = boxes.get(box.frame.parent or "")
        if parent_box is not None:
            start, end, middle = parent_box.y + parent_box.height, box.y, (parent_box.y + parent_box.height + box.y) / 2
            style = ' stroke-dasharray="5 3"' if box.lines[-1] == "static" else ""
            lines.append(
                f'<path d="M{parent_box.x:.1f} {start:.1f}C{parent_box.x:.1f} {middle:.1f} {box.x:.1f} {middle:.1f} '
                f'{box.x:.1f} {end:.1f}" fill="none" stroke="#555"{style}/>'
            )
    lines += [_box_svg(box) for box in boxes.values()]
    return "\n".join([*lines, "</svg>"]) + "\n"


def _box_svg(box: _Box) -> str:
    fill_color = "#e8eef7" if box.frame.parent is None else "#f7f7f2"
    elements = [
        f'<rect x="{box.x - box.width / 2:.1f}" y="{box.y:.1f}" width="{box.width:.1f}" height="{box.height:.1f}" '
        f'rx="9" fill="{fill_color}" stroke="#333"/>'
    ]
    for number, line in enumerate(box.lines):
        style = ' font-weight="bold"' if not number else ' fill="#444"'
        y = box.y + MARGIN / 2 + (number + 0.75) * LINE_HEIGHT
        elements.append(f'<text x="{box.x:.1f}" y="{y:.1f}" text-anchor="middle"{style}>{escape(line)}</text>')
    return "\n".join(elements)
