"""``python -m pyros1.cli.make_index``: makes `index` and README's table of commands from the records."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pyros1.cli import registry

TARGET = Path(__file__).with_name("index.py")
_HEAD = '''"""All commands and verbs, so that nothing is imported but what runs.

Made by ``python -m pyros1.cli.make_index``; do not edit. See `registry.CommandEntry` and `registry.VerbEntry`.
"""

# ruff: noqa
# fmt: off

from __future__ import annotations

from typing import Any

INDEX: dict[str, tuple[Any, ...]] = {
'''


def text() -> str:
    """Return the text of `index`, made from the records."""
    lines = [_HEAD]
    for name, told in sorted(registry.describe(module) for module in registry.modules()):
        lines.append(f"    {name!r}: (\n")
        lines += [f"        {each!r},\n" for each in told[:-1]]
        lines.append("        {\n")
        verbs: dict[str, tuple[Any, ...]] = {}
        for module in registry.modules(told[0]):
            verbs.update(registry.describe_verbs(module))
        for verb in registry.load_command(name).sorted(verbs):
            lines.append(f"            {verb!r}: {verbs[verb]!r},\n")
        lines.append("        },\n    ),\n")
    return "".join([*lines, "}\n"])


README = Path(__file__).parents[3] / "README.md"
"""README of the source tree; an installed pyros1 does not have it."""
_BEGIN = "<!-- made by python -m pyros1.cli.make_index -->\n"
_END = "<!-- end -->\n"


def readme_table() -> str:
    """Return README's table of commands."""
    lines = ["| `pyros1 ...` | stock ROS 1 | what it does | verbs; those that stock lacks |\n", "|---|---|---|---|\n"]
    for name, entry in registry.commands().items():
        stock = ", ".join(f"`{each}`" for each in dict.fromkeys(filter(None, [entry.stock, *entry.also])))
        known = registry.verbs(name)
        as_stock = " ".join(verb for verb, told in known.items() if not told.own)
        more = " ".join(verb for verb, told in known.items() if told.own)
        verbs = f"{as_stock}; *{more}*" if more else as_stock
        lines.append(f"| `{name}` | {stock} | {entry.about} | {verbs} |\n")
    return "".join(lines)


def readme(text: str) -> str:
    """Return README's text with its table made from the records."""
    before, _, rest = text.partition(_BEGIN)
    return before + _BEGIN + readme_table() + _END + rest.partition(_END)[2]


if __name__ == "__main__":
    TARGET.write_text(text(), encoding="utf-8")
    if README.exists():
        README.write_text(readme(README.read_text(encoding="utf-8")), encoding="utf-8")
