"""``pyros1 stack``: rosstack."""

from __future__ import annotations

from pyros1.cli.pkg import run


def main(argv: list[str]) -> int:
    """Run ``pyros1 stack``; returns the exit code."""
    return run("rosstack", argv)
