"""Imports ``pyros1.msgs.<package>``, whose modules are generated from definitions (`pyros1.finding.importing`).

The code that generates these modules is loaded with the first of them: most programs need it, most commands do not.

Python searches the entries of a package's ``__path__`` for its submodules: for each entry, it asks a finder that it
keeps in ``sys.path_importer_cache``. The ``__path__`` of `pyros1.msgs` has an entry that is not a folder, and puts the
finder for this entry into the cache itself. So there is no need for an import hook, which would also be called for the
imports of all other modules.

While one thread imports `pyros1.msgs`, another may already look for modules in its folder, since Python does not wait
for a parent package. So importing pyros1 also puts a finder of ours into the cache for this folder.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from importlib.machinery import (
    BYTECODE_SUFFIXES,
    EXTENSION_SUFFIXES,
    SOURCE_SUFFIXES,
    ExtensionFileLoader,
    FileFinder,
    ModuleSpec,
    SourceFileLoader,
    SourcelessFileLoader,
)

TYPE_CHECKING = False  # in place of typing.TYPE_CHECKING: small programs need not load typing
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from types import ModuleType
    from typing import Any

    _Strings = list[str]
else:
    _Strings = list

MSGS_PACKAGE = "pyros1.msgs"
_PATH_ENTRY = "<modules generated from definitions>"
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
        "records",
        "repair",
        "spec",
        "stubs",
        "text",
        "yamltext",
    ]
)
"""Names of pyros1's own modules in pyros1.msgs; a ROS package with such a name is imported with an underscore appended.
"""


def module_name(package: str) -> str:
    """Return the name of a ROS package's module below ``pyros1.msgs``."""
    return package + "_" if package in OWN_MODULES else package


def package_name(module: str) -> str:
    """Return the name of the ROS package that is imported as a module below ``pyros1.msgs``."""
    return module[:-1] if module[:-1] in OWN_MODULES and module.endswith("_") else module


class SearchPath(_Strings):
    """The ``__path__`` of `pyros1.msgs`, and of the packages in it.

    Args:
        folders: other folders to search.
        modules: finds and loads the generated modules.
    """

    def __init__(self, folders: Iterable[str], modules: GeneratedModules) -> None:
        super().__init__([*folders, _PATH_ENTRY])
        self.modules = modules

    def __iter__(self) -> Iterator[str]:
        """Iterate over the entries, after putting our finder back into the import system's cache.

        The import system calls this before each search, and may have discarded the finders in its cache.
        """
        sys.path_importer_cache.setdefault(_PATH_ENTRY, self.modules)
        return super().__iter__()


class GeneratedModules:
    """Finds and loads the modules of messages and services.

    Attributes:
        message_finder: the :class:`pyros1.finding.importing.MessageFinder` of the process; None until it is needed.
    """

    message_finder: Any = None

    def find_spec(self, name: str, target: ModuleType | None = None) -> ModuleSpec | None:
        """Return the import system's spec for a package with definitions, or its msg or srv module.

        Python holds the import lock while it looks for a module, so nothing is imported here. Until
        `pyros1.finding.importing` is loaded, which happens when a module is created, any package is assumed to exist.

        Raises:
            ImportError: there is no such package or type; the message suggests what may have been meant.
        """
        package, *submodule = name[len(MSGS_PACKAGE) + 1 :].split(".")
        if package in OWN_MODULES:
            return None
        if self.message_finder is not None:
            self.message_finder.check(name)
        if submodule not in ([], ["msg"], ["srv"]):
            return None
        spec = ModuleSpec(name, self, is_package=True)  # type: ignore[arg-type]  # contains all that the loader needs
        spec.submodule_search_locations = SearchPath([], self)
        return spec

    def create_module(self, spec: ModuleSpec) -> None:
        """Return None, so that the import system creates the module."""

    def exec_module(self, module: ModuleType) -> None:
        """Fill a new module with its classes; raises the same errors as :meth:`find_spec`."""
        message_finder = self.load_message_finder()
        message_finder.check(module.__name__)
        message_finder.fill(module)

    def load_message_finder(self) -> Any:
        """Return the message finder, which is created at first use."""
        if self.message_finder is None:
            new_finder = import_module("pyros1.finding.importing").MessageFinder(os.environ)
            # If another thread has created a finder in the meantime, that finder is kept.
            vars(self).setdefault("message_finder", new_finder)
        return self.message_finder


class MsgsFolderFinder(FileFinder):
    """Finds pyros1's own modules in the folder of `pyros1.msgs`, or else generated modules.

    Python's own finder for this folder does not know generated modules. If it were used, a thread that imports one
    before `pyros1.msgs` has set its ``__path__`` would find nothing, or find a folder with stubs and make it a
    namespace package.

    Args:
        folder: the folder of `pyros1.msgs`.
        modules: finds and loads the generated modules.
    """

    def __init__(self, folder: str, modules: GeneratedModules) -> None:
        super().__init__(
            folder,
            (ExtensionFileLoader, EXTENSION_SUFFIXES),
            (SourceFileLoader, SOURCE_SUFFIXES),
            (SourcelessFileLoader, BYTECODE_SUFFIXES),
        )
        self._modules = modules

    def find_spec(self, name: str, target: ModuleType | None = None) -> ModuleSpec | None:
        """Return the import system's spec for a module; raises the same errors as `GeneratedModules.find_spec`."""
        spec = super().find_spec(name, target)
        if spec is not None and spec.loader is not None:
            return spec
        return self._modules.find_spec(name, target) or spec


def prepare_import() -> None:
    """Put the finder for the folder of `pyros1.msgs` into the import system's cache, so that several threads can import
    messages at once, even while `pyros1.msgs` itself is being imported.
    """
    folder = os.path.join(os.path.dirname(os.path.dirname(__file__)), "msgs")
    if os.path.isdir(folder):  # not in an archive
        modules: Any = sys.path_importer_cache.setdefault(_PATH_ENTRY, GeneratedModules())
        sys.path_importer_cache[folder] = MsgsFolderFinder(folder, modules)


def make_search_path(folders: Iterable[str]) -> SearchPath:
    """Return the ``__path__`` of `pyros1.msgs`; if the package is reloaded, the same finder is used again.

    Args:
        folders: the folders with the package's own modules.
    """
    modules = sys.path_importer_cache.get(_PATH_ENTRY)
    return SearchPath(folders, modules if isinstance(modules, GeneratedModules) else GeneratedModules())


def finder() -> Any:
    """Return the process's :class:`pyros1.finding.importing.MessageFinder`.

    An import statement takes no arguments, so the environment of the process says where definitions are.
    """
    search_path: Any = sys.modules[MSGS_PACKAGE].__path__
    return search_path.modules.load_message_finder()
