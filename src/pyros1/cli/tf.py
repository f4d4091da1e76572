"""``pyros1 tf``: coordinate frames on live topics (L195-L199)."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from pyros1.cli.common import Invocation, run

_VERBS = {
    "echo": ("tf_echo", "print the transform between two frames"),
    "monitor": ("tf_monitor", "print how late transforms are, and how often they come"),
    "tree": ("tf_tree", "show the tree of frames with rates and ages, live"),
    "view_frames": ("tf_view", "draw the tree of frames into a file"),
    "static_transform_publisher": ("tf_static", "publish a transform that does not change"),
    "remap": ("tf_remap", "rename frames: from /tf_old to /tf"),
    "buffer_server": ("tf_server", "answer lookups of other nodes"),
    "change_notifier": ("tf_notify", "tell on /tf_changes when frames have moved"),
    "empty_listener": ("tf_listen", "look up and do no more, for measurements"),
}
"""Verb -> module in pyros1.cli, and what it does."""

_OTHERWISE = {
    "tf_echo": "echo",
    "tf_monitor": "monitor",
    "tf_remap": "remap",
    "tf_change_notifier": "change_notifier",
    "tf_empty_listener": "empty_listener",
    "view": "view_frames",
    "static": "static_transform_publisher",
}


def usage(program: str) -> str:
    """The command list."""
    lines = [f"{program} shows and publishes coordinate frames.", "", "Commands:"]
    lines += [f"\t{program} {verb:27} {about}" for verb, (_, about) in _VERBS.items()]
    lines += ["", f"Type {program} <command> -h for more detailed usage, e.g. '{program} echo -h'"]
    return "\n".join(lines)


def main(argv: list[str]) -> int:
    """Run ``pyros1 tf``.

    Args:
        argv: the words after the command's name; the stock tools' names (``tf_echo``) are verbs, too.

    Returns:
        The exit code: 64 without a known verb, 255 after wrong arguments of a verb that stock tf has, 1 after an error.
    """
    words = list(argv)
    for number, word in enumerate(words):
        if ":=" not in word:
            words[number] = _OTHERWISE.get(word, word)
            break
    return run("rostf", words, {verb: _runner(verb) for verb in _VERBS}, usage)


def _runner(verb: str) -> Callable[[Invocation], int]:
    def runner(invocation: Invocation) -> int:
        module = import_module(f"pyros1.cli.{_VERBS[verb][0]}")
        code: int = module.main(invocation)
        return code

    return runner
