"""``tf view_frames``: draws the tree of frames to a file (L198)."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.tf._drawing import Frame, format_tree, render_dot, render_svg
from pyros1.cli.commands.tf._node import LookupHints, make_pause, open_node, parse_number
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Option, Verb
from pyros1.ground.errors import ServiceError

if TYPE_CHECKING:
    from pyros1.node import Node

_NATIVE_SUFFIXES = (".svg", ".gv", ".dot")


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the tree of frames, and draw it to one or two files."""
    if args:
        raise UsageError(f"unexpected argument {args[0]!r}: use -o to name the file")
    seconds = parse_number(options.time, "the time", positive=True)
    output = Path(options.output) if options.output else None
    _check_output(output)
    with open_node(invocation, "view_frames") as node:
        frames = _request_frames(node, options.node) if options.node else _receive_frames(invocation, node, seconds)
        now = node.now().to_sec()
        source = f"from {options.node}" if options.node else f"{seconds:g} s of /tf and /tf_static"
        print(format_tree(frames, now))
        for path in [output] if output else _default_paths():
            _write_drawing(path, frames, now, f"Frames at {now:.3f}, {source}")
            print(f"{path} written", flush=True)


VERB = Verb(
    "view_frames",
    "draw the tree of frames to a file",
    Option("--node", metavar="NODE", help="get the frames from this node instead of listening"),
    Option("-o", "--output", metavar="FILE", help="file to write: .svg, .gv, .dot, or with Graphviz .pdf and others"),
    Option("-t", "--time", metavar="SECONDS", default="5", help="seconds to listen (5)"),
    examples=[
        ("", "listen for 5 s, then write frames.gv and frames.pdf or frames.svg"),
        ("-t 1 -o robot.svg", "listen for 1 s, then write an SVG"),
        ("--node /move_base", "draw the frames that this node knows"),
        ("-o frames.png", "write a PNG; needs Graphviz"),
    ],
    aliases=["view"],
    stock="view_frames",
    run=run,
)


def _default_paths() -> list[Path]:
    return [Path("frames.gv"), Path("frames.pdf" if shutil.which("dot") else "frames.svg")]


def _check_output(output: Path | None) -> None:
    """Raise CommandError if the name of the output file has no supported suffix."""
    if output is None or output.suffix in _NATIVE_SUFFIXES:
        return
    if not output.suffix:
        raise CommandError(
            f"{output} has no known suffix: use {output}.svg, {output}.gv or, with Graphviz, {output}.pdf"
        )
    if not shutil.which("dot"):
        raise CommandError(f"{output.suffix} files need Graphviz, which is not installed: use {output.stem}.svg")


def _receive_frames(invocation: Invocation, node: Node, seconds: float) -> list[Frame]:
    from pyros1.tf.buffer import Buffer  # noqa: PLC0415 - not needed for invalid arguments
    from pyros1.tf.listener import TransformListener  # noqa: PLC0415

    buffer = Buffer(max(10.0, 2 * seconds))
    with TransformListener(node, buffer):
        print(f"Listening to /tf and /tf_static for {seconds:.1f} seconds", flush=True)
        make_pause(node)(seconds)
        frames = [Frame(*state[:7]) for state in buffer.states()]
    if not frames:
        LookupHints(invocation, node, buffer).print_hint(None)
        raise CommandError(f"no transform was received within {seconds:g} s")
    return frames


def _request_frames(node: Node, node_name: str) -> list[Frame]:
    from pyros1.values.reading import load_yaml  # noqa: PLC0415 - rarely needed

    service = f"{node.resolve(node_name)}/tf2_frames"
    try:
        frame_yaml = node.service(service, "tf2_msgs/FrameGraph")().frame_yaml
    except ServiceError as error:
        raise CommandError(
            f"cannot get the frames of {node_name}: {error}. Nodes with a tf2 listener provide the service {service} "
            f"(C++ nodes only if they enable it)"
        ) from None
    rows_by_frame: dict[str, dict[str, Any]] = load_yaml(frame_yaml) or {}
    frames = [
        Frame(
            str(child),
            str(row["parent"]),
            str(row["broadcaster"]),
            None,
            float(row["rate"]),
            float(row["most_recent_transform"]),
            float(row["oldest_transform"]),
        )
        for child, row in rows_by_frame.items()
    ]
    frame_names = {frame.name for frame in frames}
    roots = dict.fromkeys(str(frame.parent) for frame in frames if frame.parent not in frame_names)
    if not frames:
        raise CommandError(f"{node_name} has no frames")
    return [*(Frame(root, None, "", None, 0.0, 0.0, 0.0) for root in roots), *frames]


def _write_drawing(path: Path, frames: list[Frame], now: float, title: str) -> None:
    try:
        if path.suffix == ".svg":
            path.write_text(render_svg(frames, now, title), encoding="utf-8")
        elif path.suffix in _NATIVE_SUFFIXES:
            path.write_text(render_dot(frames, now), encoding="utf-8")
        else:
            command = ["dot", f"-T{path.suffix[1:]}", "-o", str(path)]
            result = subprocess.run(command, input=render_dot(frames, now).encode(), capture_output=True, check=False)
            if result.returncode:
                raise CommandError(f"dot cannot write {path}: {result.stderr.decode(errors='replace').strip()}")
    except OSError as error:
        raise CommandError(f"cannot write {path}: {error.strerror}") from error
