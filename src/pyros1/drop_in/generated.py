"""``PACKAGE.msg`` and ``PACKAGE.srv`` with all names that stock's generated modules have.

Stock has a module for each definition, ``PACKAGE.msg._TYPE``, which imports what its code needs, and ``PACKAGE.msg``
imports all names of these modules. So ``from sensor_msgs.msg import *`` also brings ``std_msgs``, ``genpy`` or ``sys``,
and programs use them without an import of their own.
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
from pyros1.ground.generated import PREFIX, module_name

_IMPORTED = ("codecs", "genpy", "python3", "struct", "sys")
"""Names in each of stock's generated modules besides classes and packages of messages."""
_DICT = vars(ModuleType)["__dict__"]


class Messages:
    """Loader of ``PACKAGE``, ``PACKAGE.msg`` and ``PACKAGE.srv``, and of stock's ``PACKAGE.msg._TYPE``.

    The classes are those of ``pyros1.msgs``; each is made when it is first used.

    Args:
        library: where definitions come from.
        package: the ROS package.
        kind: ``msg``, ``srv``, or empty for the package itself.
        only: the type, for the module of a single type; empty: all types.
    """

    def __init__(self, library: Library, package: str, kind: str, only: str = "") -> None:
        self._library = library
        self._package = package
        self._kind = kind
        self._only = only

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Return the module; None leaves it to the import system."""
        return _Module(spec.name) if self._kind else None

    def exec_module(self, module: ModuleType) -> None:
        """Fill a new module."""
        module.__doc__ = f"Definitions of the ROS package {self._package}, from pyros1."
        if self._kind:
            import_module(self._source)
        else:
            vars(module)["__getattr__"] = _messages_of(self._package)

    def public(self) -> list[str]:
        """Return the names that ``from PACKAGE.msg import *`` imports."""
        return [*self._classes(), *_IMPORTED, *self._packages()]

    def modules(self) -> list[str]:
        """Return the names of the modules of single types in this one."""
        return [] if self._only else [f"_{name}" for name in self._types()]

    def value(self, module: str, name: str) -> Any:
        """Return an attribute of the module with this name.

        Raises:
            AttributeError: it does not exist; the text has a hint at the name that was probably meant.
        """
        if name == "__all__":
            return self.public()
        if name == "python3":
            return True
        if name in _IMPORTED:
            return import_module(name)
        if name.startswith("_") and name in self.modules():
            return import_module(f"{module}.{name}")
        if name.startswith("_") or (self._only and name not in self.public()):
            raise AttributeError(f"module {module} has no attribute {name}")
        try:
            return getattr(sys.modules[self._source], name)
        except AttributeError:
            if name not in self._packages():
                raise
        import_module(f"{name}.msg")
        return sys.modules[name]

    @property
    def _source(self) -> str:
        return f"{PREFIX}.{module_name(self._package)}.{self._kind}"

    def _types(self) -> list[str]:
        if self._only:
            return [self._only]
        return (self._library.messages if self._kind == "msg" else self._library.services)(self._package)

    def _modules(self) -> list[str]:
        return [] if self._only else [f"_{name}" for name in self._types()]

    def _classes(self) -> list[str]:
        parts = ("",) if self._kind == "msg" else ("", "Request", "Response")
        return [name + part for name in self._types() for part in parts]

    def _packages(self) -> list[str]:
        """Return the packages of all message types in the definitions, in their fields' definitions, and so on."""
        find: Callable[[str], Any] = self._library.message if self._kind == "msg" else self._library.service
        found: set[str] = set()
        for name in self._types():
            try:
                used = self._library.digests.dependencies(find(f"{self._package}/{name}"))
            except MessageError:  # importing it reports the error
                continue
            found.update(each.partition("/")[0] for each in used)
        return sorted(found)


class _Module(ModuleType):
    """A module whose contents come from its loader."""

    def __getattr__(self, name: str) -> Any:
        value = self._definitions.value(self.__name__, name)
        if name != "__all__":
            setattr(self, name, value)
        return value

    def __dir__(self) -> list[str]:
        return sorted({*_DICT.__get__(self), *self._definitions.public(), *self._definitions.modules()})

    @property
    def __dict__(self) -> dict[str, Any]:  # type: ignore[override]
        """All attributes: some programs look for types here."""
        for name in (*self._definitions.public(), *self._definitions.modules()):
            getattr(self, name)
        found: dict[str, Any] = _DICT.__get__(self)
        return found

    @property
    def _definitions(self) -> Messages:
        loader: Any = self.__spec__ and self.__spec__.loader
        return loader  # type: ignore[no-any-return]


def _messages_of(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package of messages.

    With stock, ``import std_msgs`` is enough for ``std_msgs.msg.String`` if any module has imported std_msgs.msg, as
    rospy does. Our modules import fewer packages.
    """

    def __getattr__(name: str) -> Any:
        if name in ("msg", "srv"):
            try:
                return import_module(f"{package}.{name}")
            except ModuleNotFoundError:
                pass
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return __getattr__
