"""Lets programs import some modules only when they use them.

Each program of stock ROS 1 in Python imports numpy (genpy names its types) and catkin_pkg with pyparsing (roslib) when
it starts, those that read bags also Cryptodome, and few use them. `.ci/run` installs this module for Debian's Python in
the fresh system in which the tests run, with a file ``lazy_imports.pth`` that imports it: each start then takes 0.1 s
of processor time instead of 0.17 s.
"""

import sys
import threading
from importlib import import_module
from types import ModuleType

_lock = threading.RLock()


class _LazyModule(ModuleType):
    def __getattr__(self, name: str) -> object:
        if sys._getframe(1).f_globals.get("__name__") == "genpy.message":
            return _NumberType(name)  # genpy only compares types with it
        return getattr(_import_really(self.__name__), name)


def _import_really(name: str) -> ModuleType:
    with _lock:
        for each in (name, name.rpartition(".")[0]):
            if isinstance(sys.modules.get(each), _LazyModule):
                del sys.modules[each]
    return import_module(name)


class _NumberType:
    """Equal to the type of that name in numpy."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __eq__(self, other: object) -> bool:
        return (getattr(other, "__module__", ""), getattr(other, "__name__", "")) == ("numpy", self._name)

    def __hash__(self) -> int:
        return hash(self._name)


def _find_in_workspaces(*args: object, **kwargs: object) -> object:
    return _import_really("catkin.find_in_workspaces").find_in_workspaces(*args, **kwargs)


def _add_lazy_module(name: str, **attributes: object) -> None:
    module = _LazyModule(name)
    vars(module).update(attributes)
    sys.modules.setdefault(name, module)


_add_lazy_module("numpy")
_add_lazy_module("catkin.find_in_workspaces", find_in_workspaces=_find_in_workspaces)
_add_lazy_module("Cryptodome.Cipher", AES=_LazyModule("Cryptodome.Cipher.AES"))
