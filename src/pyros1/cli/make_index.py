"""``python -m pyros1.cli.make_index``: makes the tables of commands from their records.

These are `index`, the one in the guide's page and, in a source tree, the one in interop/commands.md.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping
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
    for name, facts in sorted(registry.describe(module) for module in registry.modules()):
        lines.append(f"    {name!r}: (\n")
        lines += [f"        {each!r},\n" for each in facts[:-1]]
        lines.append("        {\n")
        verbs: dict[str, tuple[Any, ...]] = {}
        for module in registry.modules(facts[0]):
            verbs.update(registry.describe_verbs(module))
        for verb in registry.load_command(name).sorted(verbs):
            lines.append(f"            {verb!r}: {verbs[verb]!r},\n")
        lines.append("        },\n    ),\n")
    return "".join([*lines, "}\n"])


ROOT = Path(__file__).parents[3]
"""Root of the source tree."""
_BEGIN = "<!-- made by python -m pyros1.cli.make_index -->\n"
_END = "<!-- end -->\n"
_ROW = re.compile(r"^\| (?:L\d+)? ?\| [^|]+ \| ([^|]+) \| ([^|]+) \|$", re.MULTILINE)
"""A row about a feature of stock: the verbs that have it, and their tests."""
_TESTS = re.compile(r"`((?:tests|interop)/[^`:]+)(?:::[^`]+)?`")


def page_table(_: str = "") -> str:
    """Return the table of commands of the guide's page."""
    lines = ["| `pyros1 ...` | stock ROS 1 | what it does | verbs; those that stock lacks |\n", "|---|---|---|---|\n"]
    for name, entry in registry.commands().items():
        known = registry.verbs(name)
        programs = [entry.stock, *entry.also, *(facts.program for facts in known.values())]
        stock = ", ".join(f"`{each}`" for each in dict.fromkeys(filter(None, programs)))
        as_stock = " ".join(verb for verb, facts in known.items() if facts.stock != "")
        more = " ".join(verb for verb, facts in known.items() if facts.stock == "")
        verbs = f"{as_stock}; *{more}*" if more else as_stock
        lines.append(f"| `{name}` | {stock} | {entry.about} | {verbs} |\n")
    return "".join(lines)


def verbs_table(text: str) -> str:
    """Return the table of all verbs and commands without verbs, with the stock command and the test files of each.

    Args:
        text: the text of interop/commands.md. Its rows name verbs in the third column, and tests in the last.
    """
    shown = _test_files(text)
    lines = ["| `pyros1 ...` | stock ROS 1 | what it does | tests |\n", "|---|---|---|---|\n"]
    for line, stock, about in _commands():
        tests = " ".join(f"`{file}`" for file in shown.get(line, ()))
        lines.append(f"| `{line}` | {stock and f'`{stock}`'} | {about} | {tests} |\n")
    return "".join(lines)


def _commands() -> Iterator[tuple[str, str, str]]:
    """Yield the words after ``pyros1``, the stock command that does the same, and the description."""
    for name, entry in registry.commands().items():
        known = registry.verbs(name)
        if not known:
            yield name, entry.stock, entry.about
        for verb, facts in known.items():
            yield f"{name} {verb}", f"{entry.stock} {verb}" if facts.of_tool else facts.stock or "", facts.about


def _test_files(text: str) -> Mapping[str, list[str]]:
    """Return the test files that the rows of interop/commands.md name, for each verb.

    A command with verbs stands for all its verbs that stock's tool has.
    """
    found: dict[str, set[str]] = {}
    for about, tests in _ROW.findall(text):
        for line in re.findall(r"`([^`]+)`", about):
            name, *words = line.partition(" -")[0].split()
            verbs = words or [verb for verb, facts in registry.verbs(name).items() if facts.of_tool]
            for each in verbs or [""]:
                found.setdefault(f"{name} {each}".rstrip(), set()).update(_TESTS.findall(tests))
    return {line: sorted(files) for line, files in found.items()}


DOCUMENTS: Mapping[Path, Callable[[str], str]] = {
    ROOT / "src" / "pyros1" / "guide" / "howto" / "commands.md": page_table,
    ROOT / "interop" / "commands.md": verbs_table,
}
"""Files with a table between two marks, and functions that make the table from the file's text."""


def document(path: Path) -> str:
    """Return the text of a document with its table made from the records."""
    text = path.read_text(encoding="utf-8")
    before, _, rest = text.partition(_BEGIN)
    return before + _BEGIN + DOCUMENTS[path](text) + _END + rest.partition(_END)[2]


if __name__ == "__main__":
    made = text()
    if not TARGET.exists() or TARGET.read_text(encoding="utf-8") != made:
        TARGET.write_text(made, encoding="utf-8")
        os.execv(sys.executable, [sys.executable, "-m", "pyros1.cli.make_index"])  # documents need the new index
    for each in DOCUMENTS:
        if each.exists():
            each.write_text(document(each), encoding="utf-8")
