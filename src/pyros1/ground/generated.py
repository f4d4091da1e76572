"""The import hook for ``pyros1.msgs.<package>``, whose modules are generated from definitions
(`pyros1.finding.importing`).

The code that generates them is loaded with the first of these modules: most programs need it, most commands do not.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

PREFIX = "pyros1.msgs"
OWN_MODULES = frozenset(
    [
        "array_views",
        "arrays",
        "base",
        "check",
        "constructor",
        "copier",
        "decoder",
        "definition_cache",
        "definitions",
        "derived",
        "digest",
        "dynamic",
        "encoder",
        "factory",
        "fill",
        "generator",
        "genpy_classes",
        "json_form",
        "large_arrays",
        "nonstandard_definitions",
        "numpy_compat",
        "repair",
        "spec",
        "stubs",
        "text",
        "yamltext",
    ]
)
"""Names of pyros1's own modules in pyros1.msgs; a ROS package of such a name is imported with an underscore appended.
"""


def module_name(package: str) -> str:
    """Return the name of a ROS package's module below ``pyros1.msgs``."""
    return package + "_" if package in OWN_MODULES else package


def ros_name(module: str) -> str:
    """Return the ROS package that a module of that name stands for."""
    return module[:-1] if module[:-1] in OWN_MODULES and module.endswith("_") else module


def finder() -> Any:
    """Return the process's :class:`pyros1.finding.importing.MessageFinder`.

    An import statement takes no arguments, so the environment of the process says where definitions are.
    """
    return import_module("pyros1.finding.importing").installed(os.environ)


class Hook:
    """Finder of modules of messages and services, for ``sys.meta_path``.

    Python holds the import lock while it looks for a module, so nothing is imported meanwhile. Until
    `pyros1.finding.importing` is loaded and takes over, any package is assumed to exist; it is loaded when the
    module is created.
    """

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Answer the import system; see `pyros1.finding.importing.MessageFinder.find_spec`."""
        if not name.startswith(PREFIX + "."):
            return None
        package, *kind = name[len(PREFIX) + 1 :].split(".")
        if package in OWN_MODULES or kind not in ([], ["msg"], ["srv"]):
            return None
        return ModuleSpec(name, _Loader(), is_package=True)  # type: ignore[arg-type]  # has all a loader needs


class _Loader:
    def create_module(self, spec: ModuleSpec) -> None:
        """Leave it to the import system."""

    def exec_module(self, module: ModuleType) -> None:
        found = finder().find_spec(module.__name__)  # raises an error with a hint at what may have been meant
        found.loader.exec_module(module)


def install() -> None:
    """Install the hook, once, before the finder of folders, which would find the stubs of these modules."""
    if Hook not in sys.meta_path:
        sys.meta_path.insert(0, Hook)
