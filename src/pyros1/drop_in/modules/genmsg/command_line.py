"""Parses command-line arguments that give the search paths for message definitions."""

from __future__ import annotations

from collections.abc import Iterable

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)


def includepath_to_dict(includepath: Iterable[str] | None) -> dict[str, list[str]]:
    """Return package -> folders, from arguments of the form ``package:folder``."""
    folders: dict[str, list[str]] = {}
    for argument in includepath or ():
        package, colon, folder = argument.partition(":")
        if colon:
            folders.setdefault(package, []).append(folder)
    return folders
