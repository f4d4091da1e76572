"""The names under which users of ROS 1 know the commands."""

from __future__ import annotations

from pyros1.cli import registry
from pyros1.cli.legacy import CALLED_OTHERWISE
from pyros1.cli.legacy import OLD as COMMANDS

_TOOLS = {
    "dynparam": ("dynparam",),
    "tf_remap": ("tf", "remap"),
    "view_frames": ("tf", "view_frames"),
}
_NOT_STOCK = frozenset({"dynparam", "log", "tf", "tf2", "topic_tools"})


def stock_names() -> dict[str, tuple[str, ...]]:
    """Return stock name -> the words behind ``pyros1`` that do the same."""
    names: dict[str, tuple[str, ...]] = {
        f"ros{name}": (name,) for name in COMMANDS if name not in _NOT_STOCK and not name.startswith("_")
    }
    names.update({name: (command,) for name, command in CALLED_OTHERWISE.items() if command in COMMANDS})
    names.update({name: words for name, words in _TOOLS.items() if words[0] in COMMANDS})
    return dict(sorted({**names, **registry.stock_names()}.items()))
