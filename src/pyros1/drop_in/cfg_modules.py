"""Imports ``my_package.cfg.TutorialsConfig`` from ``cfg/Tutorials.cfg`` in a ROS package, without a build.

A ``.cfg`` file is a Python program that describes parameters with a ParameterGenerator. It belongs to the same package
as the node in this process, so it is run here, when the module is first imported.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from types import ModuleType
from typing import Any

_SUFFIX = "Config"
_MAX_READ_BYTES = 1 << 20
_OUR_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "modules", "dynamic_reconfigure")
_GENERATOR_MODULES = ("parameter_generator_catkin", "parameter_generator")


def find_config_spec(folder: str, parts: list[str], name: str) -> ModuleSpec | None:
    """Return the spec of ``PACKAGE.cfg``, or of a module in it; None if the package has no such .cfg file.

    Args:
        folder: the folder of the ROS package.
        parts: the parts of the module's name below ``PACKAGE.cfg``.
        name: the module's full name.
    """
    match parts:
        case []:
            cfg_folder = os.path.join(folder, "cfg") + os.sep
            if any(path.startswith(cfg_folder) or _describes_parameters(path) for path in _cfg_files(folder)):
                return ModuleSpec(name, _PackageLoader(folder), is_package=True)  # type: ignore[arg-type]
        case [module] if module.endswith(_SUFFIX):
            file_name = f"{module.removesuffix(_SUFFIX)}.cfg"
            for path in _cfg_files(folder):
                if os.path.basename(path) == file_name and os.path.isfile(path):
                    return ModuleSpec(name, _ConfigLoader(path), origin=path)  # type: ignore[arg-type]
    return None


def _cfg_files(folder: str) -> Iterator[str]:
    """Yield a ROS package's .cfg files: first the ones anywhere below cfg/, then the ones directly in other folders."""
    for root, _, files in os.walk(os.path.join(folder, "cfg")):
        yield from (os.path.join(root, file) for file in sorted(files) if file.endswith(".cfg"))
    try:
        other_folders = sorted(entry.path for entry in os.scandir(folder) if entry.is_dir() and entry.name != "cfg")
    except OSError:
        return
    for other in other_folders:
        try:
            yield from (os.path.join(other, file) for file in sorted(os.listdir(other)) if file.endswith(".cfg"))
        except OSError:
            continue


def _describes_parameters(path: str) -> bool:
    """Return whether a .cfg file is for dynamic_reconfigure: other programs use this suffix, too."""
    if not os.path.isfile(path):  # reading a pipe or a device may never finish
        return False
    try:
        with open(path, "rb") as file:
            return b"ParameterGenerator" in file.read(_MAX_READ_BYTES)
    except OSError:
        return False


class _PackageLoader:
    """Loader of ``PACKAGE.cfg``."""

    def __init__(self, folder: str) -> None:
        self._folder = folder

    def create_module(self, spec: ModuleSpec) -> None:
        """Return None, so that the import system creates the module."""

    def exec_module(self, module: ModuleType) -> None:
        """Set the docstring; the module contains only submodules."""
        module.__doc__ = f"Reconfigurable parameters of nodes in {self._folder}."


class _ConfigLoader:
    """Loader of a module from a .cfg file."""

    def __init__(self, path: str) -> None:
        self._path = path

    def create_module(self, spec: ModuleSpec) -> None:
        """Return None, so that the import system creates the module."""

    def exec_module(self, module: ModuleType) -> None:
        """Run the file, and fill the module with the parameters that it describes."""
        from dynamic_reconfigure.encoding import extract_params  # noqa: PLC0415

        vars(module).update(run_cfg_file(self._path), extract_params=extract_params, __file__=self._path)


class _RunningFiles(threading.local):
    """The .cfg files that this thread is running (they may be nested), with the descriptions collected so far."""

    def __init__(self) -> None:
        self.results: list[list[dict[str, Any]]] = []


_RUNNING = _RunningFiles()


def run_cfg_file(path: str) -> dict[str, Any]:
    """Run a .cfg file, and return the attributes of the module that it describes.

    Raises:
        ImportError: the file is not Python 3, raises an exception, or describes no parameters.
    """
    descriptions: list[dict[str, Any]] = []
    _RUNNING.results.append(descriptions)
    try:
        with _our_generators():
            exec(_compile(path), {"__name__": "__main__", "__file__": path})
    except SystemExit:  # the usual end: exit(gen.generate(...))
        pass
    except SyntaxError as error:
        location = f"{path}, line {error.lineno}" if error.lineno else path
        raise ImportError(f"{location}: {error.msg}. Is the file written in Python 2?", path=path) from error
    except Exception as error:
        raise ImportError(f"{path}: {type(error).__name__}: {error}", path=path) from error
    finally:
        _RUNNING.results.pop()
    if not descriptions:
        raise ImportError(f"{path} does not call generate() of a ParameterGenerator", path=path)
    return descriptions[0]


@contextmanager
def _our_generators() -> Iterator[None]:
    """In a ``with`` block, make .cfg files use pyros1's ParameterGenerator, even if the program imports another
    dynamic_reconfigure.

    Stock's generator, which may be on PYTHONPATH, writes source files for a build.
    """
    names = [f"dynamic_reconfigure.{short}" for short in _GENERATOR_MODULES]
    specs = [find_spec(name) for name in names]
    if all(spec is not None and os.path.dirname(spec.origin or "") == _OUR_FOLDER for spec in specs):
        yield
        return
    other_modules = {name: sys.modules.pop(name) for name in names if name in sys.modules}
    try:
        for name, short in zip(names, _GENERATOR_MODULES, strict=True):
            spec = spec_from_file_location(name, os.path.join(_OUR_FOLDER, f"{short}.py"))
            assert spec is not None and spec.loader is not None
            sys.modules[name] = module = module_from_spec(spec)
            spec.loader.exec_module(module)
        yield
    finally:
        for name in names:
            sys.modules.pop(name, None)
        sys.modules.update(other_modules)


def _compile(path: str) -> Any:
    with open(path, "rb") as file:
        text = file.read()
    try:
        return compile(text, path, "exec")
    except ValueError as error:  # Python 3.10 raises it for null bytes
        raise SyntaxError(str(error)) from error


def add_description(description: dict[str, Any]) -> None:
    """Add the description that a ParameterGenerator has collected to the results of the .cfg file that is running.

    Raises:
        NotImplementedError: the file was run as a program instead of being imported.
    """
    if not _RUNNING.results:
        raise NotImplementedError(
            "pyros1 does not generate files from .cfg files, and does not need them: import PACKAGE.cfg.NAMEConfig"
        )
    _RUNNING.results[-1].append(description)
