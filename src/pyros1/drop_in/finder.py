"""Import hook for the modules of stock ROS 1, for message packages, and for the Python modules of ROS packages.

It stands at the end of ``sys.meta_path``: whatever else can be imported wins. If that is a real rospy, none of our
modules is offered, since both kinds of messages and nodes do not mix; ``PYROS1_ROSPY=pyros1`` puts the hook first.
"""

from __future__ import annotations

import os
import sys
from _thread import get_ident
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Any

VARIABLE = "PYROS1_ROSPY"
"""Environment variable: "pyros1" prefers our modules to installed ones, "stock" leaves ours out."""
MODULES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "modules")
"""Folder of our modules."""


class Finder:
    """Finder for ``sys.meta_path``.

    Args:
        environ: environment variables, for the places of ROS packages.
        folder: where our modules are.
    """

    def __init__(self, environ: Any = os.environ, folder: str = MODULES) -> None:
        self._environ = environ
        self._folder = folder
        self._names = frozenset(name.partition(".")[0] for name in os.listdir(folder) if name[0] not in "_.")
        self._stock: bool | None = None
        self._asking: set[int] = set()
        self._index: Any = None

    @property
    def stock(self) -> bool:
        """Whether a real rospy is installed, which wins."""
        if self._stock is None:
            wanted = self._environ.get(VARIABLE, "")
            self._stock = wanted == "stock" or (wanted != "pyros1" and self._real("rospy"))
        return self._stock

    def _real(self, name: str) -> bool:
        """Return whether there is a module of that name besides ours; a folder without any is none."""
        others = [each for each in sys.meta_path if not isinstance(each, (Finder, Folders))]
        found = (each.find_spec(name, None) for each in others if hasattr(each, "find_spec"))
        return any(spec is not None and not is_folder(spec) and not self._ours(spec) for spec in found)

    def _ours(self, spec: ModuleSpec) -> bool:
        return (spec.origin or "").startswith(self._folder + os.sep)

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Answer the import system; None leaves the name to others, or to the usual error.

        Raises:
            ModuleNotFoundError: the name is below one of our modules, and pyros1 does not have it.
        """
        top, *rest = name.split(".")
        if self.stock:
            return None
        if not rest and top in self._names:
            return PathFinder.find_spec(name, [self._folder])
        if rest and path and self._below(path):
            spec = PathFinder.find_spec(name, path)
            if spec is not None and not is_folder(spec):
                return spec
        me = get_ident()
        if top in sys.stdlib_module_names or top == "pyros1" or me in self._asking:
            return None
        self._asking.add(me)  # looking for packages may import modules itself
        try:
            spec = self._of_package(top, rest, name)
        finally:
            self._asking.discard(me)
        if spec is None and top in self._names and rest[-1][:2] != "__" and path and self._below(path):
            # Another name than that of the module, else Python would forget this text in "from rospy import x".
            raise ModuleNotFoundError(f"pyros1 has no {name}", name=top)
        return spec

    def _below(self, path: Sequence[str]) -> bool:
        return any(os.fspath(each).startswith(self._folder + os.sep) for each in path)

    def _of_package(self, package: str, rest: list[str], name: str) -> ModuleSpec | None:
        from pyros1.ground.generated import PREFIX, finder, module_name  # noqa: PLC0415  few programs need definitions at once

        library = finder().library
        match rest:
            case []:
                folder = self._source(package)
                if folder is not None:
                    return PathFinder.find_spec(name, [folder])
                if library.has_package(package):
                    return ModuleSpec(name, _Messages(package, ""), is_package=True)  # type: ignore[arg-type]
                folder = self._source_elsewhere(package)
                if folder is not None:
                    return PathFinder.find_spec(name, [folder])
                if package.endswith("_msgs"):
                    raise ModuleNotFoundError(f"No module named {name!r}: {library.no_package(package)}", name=name)
            case ["msg" | "srv" as kind] if library.has_package(package):
                return ModuleSpec(name, _Messages(package, kind), is_package=True)  # type: ignore[arg-type]
            case ["msg" | "srv" as kind, module] if module[0] == "_" and library.has_package(package):
                names = library.messages(package) if kind == "msg" else library.services(package)
                if module[1:] in names:
                    return ModuleSpec(name, _Messages(package, kind))  # type: ignore[arg-type]
            case ["msg" | "srv" as kind, module] if module[:2] != "__" and library.has_package(package):
                # Asked for a type as if it were a module, since there is none: this says so, with a hint.
                finder().find_spec(f"{PREFIX}.{module_name(package)}.{kind}.{module}")
        return None

    @property
    def _packages(self) -> Any:
        if self._index is None:
            from pyros1.finding.packages import PackageIndex  # noqa: PLC0415

            self._index = PackageIndex(self._environ)
        return self._index

    def _source(self, package: str) -> str | None:
        """Return the folder in which a ROS package keeps a Python module of its own name."""
        from pyros1.drop_in.sources import folder_of  # noqa: PLC0415
        from pyros1.ground.errors import PackageNotFoundError  # noqa: PLC0415

        try:
            return folder_of(self._packages.find_folder(package), package)
        except PackageNotFoundError:
            return None

    def _source_elsewhere(self, module: str) -> str | None:
        """Return the folder in which a ROS package of another name, in ROS_PACKAGE_PATH, keeps a Python module."""
        if not self._environ.get("ROS_PACKAGE_PATH"):
            return None
        from pyros1.drop_in.sources import folder_of  # noqa: PLC0415

        folders = (folder_of(folder, module) for folder in self._packages.below_roots())
        return next(filter(None, folders), None)


class Folders:
    """Finder before Python's own one, which takes any folder for a package if there is no other of its name.

    In the source folder of a workspace lie folders like std_msgs, whose messages would then not be found.

    Args:
        finder: knows our modules and packages.
    """

    def __init__(self, finder: Finder) -> None:
        self._finder = finder

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Answer the import system."""
        if path is not None and name.rpartition(".")[2] not in ("msg", "srv"):
            return None
        spec = PathFinder.find_spec(name, path, target)
        return self._finder.find_spec(name) or spec if spec is not None and is_folder(spec) else spec


def is_folder(spec: ModuleSpec) -> bool:
    """Return whether a spec is that of a folder without ``__init__.py``."""
    return spec.origin is None and spec.submodule_search_locations is not None and not spec.has_location


class _Messages:
    """Loader of ``PACKAGE``, ``PACKAGE.msg`` and ``PACKAGE.srv``, and of stock's ``PACKAGE.msg._TYPE``.

    The classes are those of ``pyros1.msgs``.
    """

    def __init__(self, package: str, kind: str) -> None:
        self._package = package
        self._kind = kind

    def create_module(self, spec: ModuleSpec) -> None:
        """Leave it to the import system."""

    def exec_module(self, module: ModuleType) -> None:
        """Fill a new module: it makes each class when it is first used."""
        module.__doc__ = f"Definitions of the ROS package {self._package}, from pyros1."
        if not self._kind:
            return
        from pyros1.ground.generated import PREFIX, module_name  # noqa: PLC0415

        source = import_module(f"{PREFIX}.{module_name(self._package)}.{self._kind}")

        def __getattr__(name: str) -> Any:
            if name.startswith("_") and name != "__all__":
                raise AttributeError(f"module {module.__name__} has no attribute {name}")
            value = getattr(source, name)
            if name != "__all__":
                setattr(module, name, value)
            return value

        vars(module)["__getattr__"] = __getattr__
        vars(module)["__dir__"] = lambda: dir(source)


def install() -> None:
    """Install the hook in this process, once."""
    if any(isinstance(each, Finder) for each in sys.meta_path):
        return
    finder = Finder()
    if os.environ.get(VARIABLE) == "pyros1":
        sys.meta_path.insert(0, finder)
    else:
        sys.meta_path.append(finder)
    if PathFinder in sys.meta_path:
        sys.meta_path.insert(sys.meta_path.index(PathFinder), Folders(finder))
