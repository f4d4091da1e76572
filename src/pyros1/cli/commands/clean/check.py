"""``clean check`` (L179)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.clean._folders import folders
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_words
from pyros1.cli.records import JSON, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.doctor.disk import folder_size, human_size


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the size of the log folders."""
    rows = [(label, folder, folder_size(folder, on_disk=True)) for folder, label in folders()]
    if options.json:
        print_json([{"what": label, "folder": str(folder), "bytes": size} for label, folder, size in rows])
        return
    for label, _, size in rows:
        print(f"{human_size(size)} {label}")


VERB = Verb(
    "check",
    "Check usage of log files",
    JSON,
    examples=[("", "how much space they use")],
    parse=leave_words,  # the command parses
    run=run,
)
