"""Import hook for the modules of stock ROS 1, for message packages, and for the Python modules of ROS packages.

The hook is at the end of ``sys.meta_path``, so all other modules take precedence. If stock's rospy is installed, the
hook finds none of pyros1's modules, since stock's messages and nodes cannot be combined with pyros1's. With
``PYROS1_ROSPY=pyros1``, the hook is at the beginning.

Python holds the import lock while it looks for a module. The hook must not import anything during that time: another
thread may be importing the same module and waiting for that lock. So everything that it needs is imported beforehand.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import FrameType, ModuleType
from typing import Any

from pyros1.drop_in import cfg_modules
from pyros1.drop_in.message_modules import MessageModuleLoader
from pyros1.drop_in.sources import module_folder
from pyros1.drop_in.unicode_errors import register
from pyros1.drop_in.unsupported import reason_for
from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import PackageNotFoundError
from pyros1.ground.msgs_imports import MSGS_PACKAGE, finder, module_name

PREFERENCE_VARIABLE = "PYROS1_ROSPY"
"""Environment variable: "pyros1" prefers pyros1's modules to installed ones, "stock" disables them."""
MODULES_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "modules")
"""Folder of pyros1's modules."""


def _is_existence_check() -> bool:
    """Return whether the program only checks if a module exists; `importlib.util.find_spec` must then return None."""
    frame: FrameType | None = sys._getframe(1)
    our_modules = (__name__, "pyros1_modules", "importlib._bootstrap")
    while frame is not None and frame.f_globals.get("__name__") in our_modules:
        frame = frame.f_back
    return frame is not None and frame.f_globals.get("__name__") == "importlib.util"


class Finder:
    """Finder for ``sys.meta_path``.

    Args:
        environ: environment variables that contain the paths of ROS packages.
        folder: the folder of pyros1's modules.
    """

    def __init__(self, environ: Any = os.environ, folder: str = MODULES_FOLDER) -> None:
        self._environ = environ
        self._folder = folder
        self._module_names = frozenset(name.partition(".")[0] for name in os.listdir(folder) if name[0] not in "_.")
        self._uses_stock: bool | None = None
        self._library = finder().library
        self._index = PackageIndex(environ)
        self._package_spec("std_msgs", [], "std_msgs")  # this first lookup imports everything that later ones need

    @property
    def uses_stock(self) -> bool:
        """Whether stock's modules are used: as PYROS1_ROSPY says, otherwise if stock's rospy is installed."""
        if self._uses_stock is None:
            preference = self._environ.get(PREFERENCE_VARIABLE, "")
            self._uses_stock = preference == "stock" or (preference != "pyros1" and self._has_stock_rospy())
        return self._uses_stock

    def _has_stock_rospy(self) -> bool:
        spec = PathFinder.find_spec("rospy")  # a folder without modules is ignored
        return spec is not None and spec.has_location and not (spec.origin or "").startswith(self._folder + os.sep)

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of a module; None to leave it to other finders, or to let Python raise its usual error.

        Raises:
            ImportError: pyros1 has no such module, or the message package no such type.
        """
        top_name, *submodules = name.split(".")
        if top_name == "pyros1" or top_name in sys.stdlib_module_names or self.uses_stock:
            return None
        if not submodules and top_name in self._module_names:
            return PathFinder.find_spec(name, [self._folder])
        is_in_our_folder = path is not None and any(
            os.fspath(entry).startswith(self._folder + os.sep) for entry in path
        )
        spec = PathFinder.find_spec(name, path) if is_in_our_folder else None
        if spec is not None and spec.has_location:
            return spec
        spec = self._package_spec(top_name, submodules, name)
        if spec is None and is_in_our_folder and not submodules[-1].startswith("__"):
            # Pass the package as `name`, not the missing module: "from rospy import x" would discard this message.
            raise ModuleNotFoundError(f"pyros1 has no {name}{reason_for(name)}", name=top_name)
        if spec is None and not submodules and reason_for(name) and not _is_existence_check():
            raise ModuleNotFoundError(
                f"No module named {name!r}: it is not part of pyros1{reason_for(name)}", name=name
            )
        return spec

    def _package_spec(self, package: str, submodules: list[str], name: str) -> ModuleSpec | None:  # noqa: PLR0911
        match submodules:
            case []:
                folder = self._source_folder(package)
                if folder is not None:
                    return PathFinder.find_spec(name, [folder])
                if self._library.has_package(package) or self._config_spec(package, [], name):
                    return ModuleSpec(name, MessageModuleLoader(self._library, package, ""), is_package=True)  # type: ignore[arg-type]
                folder = self._source_in_other_package(package)
                if folder is not None:
                    return PathFinder.find_spec(name, [folder])
                if package.endswith("_msgs"):
                    raise ModuleNotFoundError(
                        f"No module named {name!r}: {self._library.missing_package_message(package)}", name=name
                    )
            case ["cfg", *parts]:
                return self._config_spec(package, parts, name)
            case ["msg" | "srv" as kind] if self._library.has_package(package):
                if not self._type_names(package, kind):
                    type_kind = "messages" if kind == "msg" else "services"
                    message = f"No module named {name!r}: the package {package} has no {type_kind}"
                    raise ModuleNotFoundError(message, name=name)
                return ModuleSpec(name, MessageModuleLoader(self._library, package, kind), is_package=True)  # type: ignore[arg-type]
            case ["msg" | "srv" as kind, module] if module[:2] != "__" and self._library.has_package(package):
                if module[0] != "_":  # e.g. std_msgs.msg.String for _String: check() raises an error with a hint
                    finder().check(f"{MSGS_PACKAGE}.{module_name(package)}.{kind}.{module}")
                if module[1:] in self._type_names(package, kind):
                    return ModuleSpec(name, MessageModuleLoader(self._library, package, kind, module[1:]))  # type: ignore[arg-type]
        return None

    def _type_names(self, package: str, kind: str) -> list[str]:
        names: list[str] = (self._library.messages if kind == "msg" else self._library.services)(package)
        return names

    def _source_folder(self, package: str) -> str | None:
        """Return the folder in which a ROS package has a Python module with the package's name."""
        try:
            return module_folder(self._index.find_folder(package), package)
        except PackageNotFoundError:
            return None

    def _source_in_other_package(self, module: str) -> str | None:
        """Return the folder of a Python module in any package in ROS_PACKAGE_PATH, whatever the package's name is."""
        folders = (module_folder(folder, module) for folder in self._index.packages_below_roots())
        return next(filter(None, folders), None)

    def _config_spec(self, package: str, submodules: list[str], name: str) -> ModuleSpec | None:
        """Return the spec of ``PACKAGE.cfg``, or of a module in it, from the package's .cfg files."""
        try:
            return cfg_modules.find_config_spec(self._index.find_folder(package), submodules, name)
        except PackageNotFoundError:
            return None


def install() -> Finder:
    """Install the hook in this process unless it is already installed, and return it."""
    for existing_finder in sys.meta_path:
        if isinstance(existing_finder, Finder):
            return existing_finder
    our_finder = Finder()
    if not our_finder.uses_stock:
        finder().uses_stock_names = True
        register()
    if os.environ.get(PREFERENCE_VARIABLE) == "pyros1":
        sys.meta_path.insert(0, our_finder)
    else:
        sys.meta_path.append(our_finder)
    return our_finder
