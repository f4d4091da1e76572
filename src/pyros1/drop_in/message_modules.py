"""Creates ``PACKAGE.msg`` and ``PACKAGE.srv`` with all names that stock's generated modules have.

Stock has a module for each definition, ``PACKAGE.msg._TYPE``, which imports the modules that its code needs, and
``PACKAGE.msg`` imports all names from these modules. So ``from sensor_msgs.msg import *`` also imports ``std_msgs``,
``genpy`` or ``sys``, and programs use them without importing them explicitly.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from pyros1.finding.library import Library
from pyros1.ground.errors import MessageError
from pyros1.ground.msgs_imports import MSGS_PACKAGE, module_name

_IMPORTED_NAMES = ("codecs", "genpy", "python3", "struct", "sys")
"""Names in each of stock's generated modules besides classes and message packages."""
_MODULE_DICT = vars(ModuleType)["__dict__"]


class MessageModuleLoader:
    """Loader of ``PACKAGE``, ``PACKAGE.msg`` and ``PACKAGE.srv``, and of stock's ``PACKAGE.msg._TYPE``.

    The classes come from ``pyros1.msgs``, and are created when they are first used.

    Args:
        library: provides the definitions.
        package: the ROS package.
        kind: ``msg``, ``srv``, or empty for the package itself.
        only_type: the type, for the module of a single type; empty for all types.
    """

    def __init__(self, library: Library, package: str, kind: str, only_type: str = "") -> None:
        self._library = library
        self._package = package
        self._kind = kind
        self._only_type = only_type

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Create and return the module; None to let the import system create it."""
        return _Module(spec.name) if self._kind else None

    def exec_module(self, module: ModuleType) -> None:
        """Initialise a new module: its attributes are created when they are first used."""
        module.__doc__ = f"Definitions of the ROS package {self._package}, from pyros1."
        if self._kind:
            import_module(self._source)
        else:
            vars(module)["__getattr__"] = _make_package_getattr(self._package)

    def public_names(self) -> list[str]:
        """Return the names that ``from PACKAGE.msg import *`` imports."""
        return [*self._class_names(), *_IMPORTED_NAMES, *self._package_names()]

    def module_names(self) -> list[str]:
        """Return the names of this module's submodules, one for each type."""
        return [] if self._only_type else [f"_{name}" for name in self._type_names()]

    def get_attribute(self, module: str, name: str) -> Any:
        """Return the value of an attribute of the module.

        Raises:
            AttributeError: the attribute does not exist; the message may suggest a similar name.
        """
        if name == "__all__":
            return self.public_names()
        if name == "python3":
            return True
        if name in _IMPORTED_NAMES:
            return import_module(name)
        if name.startswith("_") and name in self.module_names():
            return import_module(f"{module}.{name}")
        if name.startswith("_") or (self._only_type and name not in self.public_names()):
            raise AttributeError(f"module {module} has no attribute {name}")
        try:
            return getattr(sys.modules[self._source], name)
        except AttributeError:
            if name not in self._package_names():
                raise
        import_module(f"{name}.msg")
        return sys.modules[name]

    @property
    def _source(self) -> str:
        return f"{MSGS_PACKAGE}.{module_name(self._package)}.{self._kind}"

    def _type_names(self) -> list[str]:
        if self._only_type:
            return [self._only_type]
        return (self._library.messages if self._kind == "msg" else self._library.services)(self._package)

    def _modules(self) -> list[str]:
        return [] if self._only_type else [f"_{name}" for name in self._type_names()]

    def _class_names(self) -> list[str]:
        suffixes = ("",) if self._kind == "msg" else ("", "Request", "Response")
        return [name + suffix for name in self._type_names() for suffix in suffixes]

    def _package_names(self) -> list[str]:
        """Return the packages of all message types that the definitions use, directly or indirectly."""
        find_definition: Callable[[str], Any] = self._library.message if self._kind == "msg" else self._library.service
        packages: set[str] = set()
        for name in self._type_names():
            try:
                used_types = self._library.digests.dependencies(find_definition(f"{self._package}/{name}"))
            except MessageError:  # reported when the type is imported
                continue
            packages.update(type_name.partition("/")[0] for type_name in used_types)
        return sorted(packages)


class _Module(ModuleType):
    """A module whose attributes are provided by its loader."""

    def __getattr__(self, name: str) -> Any:
        value = self._definitions.get_attribute(self.__name__, name)
        if name != "__all__":
            setattr(self, name, value)
        return value

    def __dir__(self) -> list[str]:
        return sorted(
            {*_MODULE_DICT.__get__(self), *self._definitions.public_names(), *self._definitions.module_names()}
        )

    @property
    def __dict__(self) -> dict[str, Any]:  # type: ignore[override]
        """All attributes, even ones not used so far, since some programs search this dictionary for types."""
        for name in (*self._definitions.public_names(), *self._definitions.module_names()):
            getattr(self, name)
        attributes: dict[str, Any] = _MODULE_DICT.__get__(self)
        return attributes

    @property
    def _definitions(self) -> MessageModuleLoader:
        loader: Any = self.__spec__ and self.__spec__.loader
        return loader  # type: ignore[no-any-return]


def _make_package_getattr(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a message package.

    In stock ROS, ``import std_msgs`` suffices to use ``std_msgs.msg.String`` once any module, such as rospy, has
    imported std_msgs.msg. pyros1's modules import fewer packages, so the submodule is imported on demand.
    """

    def __getattr__(name: str) -> Any:
        if name in ("msg", "srv"):
            try:
                return import_module(f"{package}.{name}")
            except ModuleNotFoundError:
                pass
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return __getattr__
