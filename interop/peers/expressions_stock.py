"""What stock makes of expressions: run by `test_expressions.py` with Debian's Python. Reads and writes JSON."""

from __future__ import annotations

import contextlib
import importlib
import json
import math
import os
import sys
from typing import Any

import rosbag
from rosbag.rosbag_main import filter_cmd
from roslaunch.substitution_args import resolve_args


def filtered(bag: str, expression: str) -> Any:
    """Return the numbers of the messages that `rosbag filter` keeps; None if it fails."""
    out = bag + ".out.bag"
    try:
        with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
            filter_cmd([bag, out, expression])
        with rosbag.Bag(out) as kept:
            return [t.to_nsec() // 10**9 for _, _, t in kept.read_messages()]
    except Exception:  # noqa: BLE001 - of any kind
        return None
    finally:
        if os.path.exists(out):
            os.remove(out)


def plain(value: Any) -> Any:
    """Return a value as JSON."""
    if hasattr(value, "nsecs"):
        return value.to_nsec()
    if hasattr(value, "__slots__") and hasattr(value, "_slot_types"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (list, tuple, map)):
        return [plain(each) for each in value]
    if isinstance(value, float):
        return round(value, 9) if math.isfinite(value) else str(value)
    return value.decode("latin-1") if isinstance(value, bytes) else value


def transformed(messages: Any, topic: str, expression: str, modules: Any) -> Any:
    """Return the value of an expression of topic_tools transform; None if it fails."""
    try:
        names = {name: importlib.import_module(name) for name in ("numpy", *modules)}
        for name in modules:
            if name.endswith("_msgs"):
                importlib.import_module(name + ".msg")  # the tool has loaded that of its output
        return plain(eval(expression, names, {"m": messages[topic]}))  # noqa: S307 - what stock does with it
    except Exception:  # noqa: BLE001 - of any kind
        return None


def evaluated(expression: str, arguments: Any) -> Any:
    """Return the text of ``$(eval ...)``; None if it fails."""
    try:
        return resolve_args(f"$(eval {expression})", context={"arg": arguments})
    except Exception:  # noqa: BLE001 - of any kind
        return None


def main() -> None:
    """Print the results."""
    asked = json.load(sys.stdin)
    with rosbag.Bag(asked["bag"]) as bag:
        messages = {topic: message for topic, message, _ in bag.read_messages()}
    results = {
        "filters": [filtered(asked["bag"], text) for text in asked["filters"]],
        "transforms": [transformed(messages, *each) for each in asked["transforms"]],
        "evals": [evaluated(text, asked["arguments"]) for text in asked["evals"]],
    }
    json.dump(results, sys.stdout)


if __name__ == "__main__":
    main()
