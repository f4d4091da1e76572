"""Programs of ours under the names of stock tools, those too whose names do not begin with ``ros``."""

from __future__ import annotations

import sys
from pathlib import Path

from harness import SOURCE

from pyros1.cli.registry import stock_names


def named_tool(folder: Path, name: str) -> str:
    """Write a program.

    Args:
        folder: where to.
        name: the stock tool's, as ``pyros1 setup`` puts it on the PATH.

    Returns:
        Its path.
    """
    path = folder / name
    words = list(stock_names()[name])
    path.write_text(
        f"#!{sys.executable}\nimport sys; sys.path.insert(0, {str(SOURCE)!r}); from pyros1.cli.main import entry\n"
        f"sys.exit(entry(['pyros1', *{words!r}, *sys.argv[1:]]))\n"
    )
    path.chmod(0o755)
    return str(path)
