"""Import of ``pyros1.msgs.<package>``, whose modules are generated from definitions (`pyros1.finding.importing`).

The code that generates them is loaded with the first of these modules: most programs need it, most commands do not.

Python searches the entries of a package's ``__path__`` for its submodules, and asks for each a finder that it keeps in
``sys.path_importer_cache``. The ``__path__`` of `pyros1.msgs` has an entry that is no folder, and puts its finder there
itself, so no hook is needed that would see the imports of other modules, too.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from importlib.machinery import ModuleSpec

TYPE_CHECKING = False  # as in typing, which small programs need not load
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from types import ModuleType
    from typing import Any

    _Strings = list[str]
else:
    _Strings = list

PREFIX = "pyros1.msgs"
_ENTRY = "<modules generated from definitions>"
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


class SearchPath(_Strings):
    """The ``__path__`` of `pyros1.msgs`, and of the packages in it.

    Args:
        folders: folders to search as well.
        modules: the finder of generated modules.
    """

    def __init__(self, folders: Iterable[str], modules: GeneratedModules) -> None:
        super().__init__([*folders, _ENTRY])
        self.modules = modules

    def __iter__(self) -> Iterator[str]:
        """Iterate, after putting our finder back into the import system's cache.

        The import system iterates here before each search, and may have discarded its finders.
        """
        sys.path_importer_cache.setdefault(_ENTRY, self.modules)
        return super().__iter__()


class GeneratedModules:
    """Finder and loader of modules of messages and services.

    Attributes:
        messages: the :class:`pyros1.finding.importing.MessageFinder` of the process; None until it is needed.
    """

    messages: Any = None

    def find_spec(self, name: str, target: ModuleType | None = None) -> ModuleSpec | None:
        """Return the import system's spec for a package with definitions, or its msg or srv module.

        Python holds the import lock while it looks for a module, so nothing is imported meanwhile. Until
        `pyros1.finding.importing` is loaded, any package is assumed to exist; it is loaded when the module is created.

        Raises:
            ImportError: there is no such package or type; the text has a hint at what may have been meant.
        """
        package, *kind = name[len(PREFIX) + 1 :].split(".")
        if package in OWN_MODULES:
            return None
        if self.messages is not None:
            self.messages.check(name)
        if kind not in ([], ["msg"], ["srv"]):
            return None
        spec = ModuleSpec(name, self, is_package=True)  # type: ignore[arg-type]  # has all a loader needs
        spec.submodule_search_locations = SearchPath([], self)
        return spec

    def create_module(self, spec: ModuleSpec) -> None:
        """Leave it to the import system."""

    def exec_module(self, module: ModuleType) -> None:
        """Fill a new module; raises as :meth:`find_spec`."""
        messages = finder()
        messages.check(module.__name__)
        messages.fill(module)


def search_path(folders: Iterable[str]) -> SearchPath:
    """Return the ``__path__`` of `pyros1.msgs`, with the same finder if that is reloaded.

    Args:
        folders: the folders with its own modules.
    """
    modules = sys.path_importer_cache.get(_ENTRY)
    return SearchPath(folders, modules if isinstance(modules, GeneratedModules) else GeneratedModules())


def finder() -> Any:
    """Return the process's :class:`pyros1.finding.importing.MessageFinder`.

    An import statement takes no arguments, so the environment of the process says where definitions are.
    """
    search: Any = sys.modules[PREFIX].__path__
    modules: GeneratedModules = search.modules
    if modules.messages is None:
        made = import_module("pyros1.finding.importing").MessageFinder(os.environ)
        vars(modules).setdefault("messages", made)  # another thread may have made one meanwhile: the first one stays
    return modules.messages
