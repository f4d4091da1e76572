"""``python -m pyros1.cli.make_index``: makes the table of commands and verbs from their records."""

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
    """Return the table, as the records have it."""
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


if __name__ == "__main__":
    TARGET.write_text(text(), encoding="utf-8")
