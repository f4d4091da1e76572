"""``pyros1 unsetup``: see `setup`."""

from __future__ import annotations

from pyros1.cli import setup


def main(argv: list[str]) -> int:
    """Run ``pyros1 unsetup``; returns the exit code."""
    return setup.main(argv, "unsetup")
