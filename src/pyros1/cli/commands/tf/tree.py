"""``tf tree``: displays the tree of frames in the terminal, with rates and ages, and updates it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.tf._drawing import Frame, format_tree
from pyros1.cli.commands.tf._node import LookupHints, make_pause, open_node, parse_number
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Flag, Option, Verb
from pyros1.cli.shared.printing import print_json

if TYPE_CHECKING:
    from pyros1.tf.buffer import Buffer

_CLEAR_SCREEN = "\033[H\033[J"


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print the tree once, or on a terminal until interrupted. Return 1 if no transform was received."""
    if args:
        raise UsageError(f"unexpected argument {args[0]!r}")
    seconds = parse_number(options.time, "the time", positive=True)
    is_live = sys.stdout.isatty() and not options.once and not options.json
    with open_node(invocation, "tf_tree") as node:
        from pyros1.tf.buffer import Buffer  # noqa: PLC0415 - not needed for invalid arguments
        from pyros1.tf.listener import TransformListener  # noqa: PLC0415

        buffer = Buffer(max(10.0, 2 * seconds))
        with TransformListener(node, buffer):
            hints = LookupHints(invocation, node, buffer)
            pause = make_pause(node)
            while pause(seconds):
                frames = buffer.frames()
                if not frames:
                    hints.print_hint(None)
                elif options.json:
                    print_json(_as_json(buffer, node.now().to_sec()))
                else:
                    _print_tree(buffer, lambda: node.now().to_sec(), is_live)
                if not is_live:
                    return 0 if frames or options.json else 1
    return 0


VERB = Verb(
    "tree",
    "show the tree of frames with rates and ages, live",
    Option("-t", "--time", metavar="SECONDS", default="1", help="seconds to listen before each update (1)"),
    Flag("--once", help="print the tree once"),
    Flag("--json", help="print a JSON list of frames, once"),
    examples=[
        ("", "update the tree until Ctrl-C on a terminal, otherwise print it once"),
        ("--once -t 3", "print the tree once, after listening for 3 s"),
        ("--json", "print the tree once as JSON"),
    ],
    stock="",
    run=run,
)


def _print_tree(buffer: Buffer, now: Callable[[], float], clear_screen: bool) -> None:
    tree_text = format_tree([Frame(*state[:7]) for state in buffer.states()], now())
    print(f"{_CLEAR_SCREEN}{tree_text}" if clear_screen else tree_text, flush=True)


def _as_json(buffer: Buffer, now: float) -> list[dict[str, object]]:
    return [
        {
            "frame_id": state.name,
            "parent": state.parent,
            "broadcaster": state.authority if state.parent is not None else None,
            "static": state.static,
            "rate": round(state.rate, 3) or None,
            "age": round(now - state.latest, 6) if state.latest else None,
            "transforms": state.transforms,
        }
        for state in buffer.states()
    ]
