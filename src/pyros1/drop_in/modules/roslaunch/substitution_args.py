"""Replaces ``$(arg x)`` and similar in strings from launch files."""

from __future__ import annotations

import os
from typing import Any

from pyros1.ground.errors import LaunchError, PackageNotFoundError
from pyros1.launch.reading.scope import Scope, ScopeSubstituter
from pyros1.launch.reading.substitution import substitute
from pyros1.launch.reading.system_resources import make_resources
from roslaunch.loader import convert_value

__all__ = ["ArgException", "SubstitutionException", "convert_value", "resolve_args"]


_rospack: Any = None  # programs set it to None so that new packages are found; pyros1 always finds them


class SubstitutionException(Exception):
    """A substitution is not possible."""


class ArgException(SubstitutionException):
    """An argument has no value."""


class _DictSubstituter(ScopeSubstituter):
    """Looks up values in a dictionary that the program provides."""

    def __init__(self, context: dict[str, Any], filename: str) -> None:
        self._context = context
        self._arguments: dict[str, Any] = context.get("arg", {})
        super().__init__(Scope(make_resources(), filename, anonymous_names=context.setdefault("anon", {})))

    def arg(self, name: str) -> str:
        """Return an argument's value."""
        if name not in self._arguments:
            raise ArgException(name)
        return str(self._arguments[name])

    def args(self) -> dict[str, str]:
        """Return all arguments."""
        return {name: str(value) for name, value in self._arguments.items()}

    def dirname(self) -> str:
        """Return the folder of the file."""
        path = self._context.get("filename")
        if path is None:
            raise SubstitutionException("Cannot substitute $(dirname), no file/directory information available.")
        return os.path.abspath(os.path.dirname(path))


def resolve_args(
    arg_str: str, context: dict[str, Any] | None = None, resolve_anon: bool = True, filename: str | None = None
) -> str:
    """Replace all ``$(...)`` in a string.

    Args:
        arg_str: the string.
        context: ``{"arg": {name: value}}``; unique names of ``$(anon x)`` are kept in it.
        resolve_anon: accepted for compatibility: ``$(anon x)`` is always replaced.
        filename: the file that contains the string, for ``$(dirname)``.

    Raises:
        ArgException: an argument has no value.
        rospkg.ResourceNotFound: there is no such package.
        SubstitutionException: a substitution fails for another reason.
    """
    if not arg_str:
        return arg_str
    context = {} if context is None else context
    if filename is not None:
        context["filename"] = filename
    try:
        return substitute(arg_str, _DictSubstituter(context, filename or "<text>"))
    except LaunchError as error:
        if isinstance(error.__cause__, PackageNotFoundError):
            from rospkg import ResourceNotFound

            raise ResourceNotFound(str(error)) from error
        raise SubstitutionException(str(error)) from error
