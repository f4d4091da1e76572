"""Finds errors that prevent Python nodes from starting: syntax errors, and modules that cannot be found."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
import threading
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from pyros1.finding.packages import PackageIndex
from pyros1.finding.python_modules import MODULES_FOLDER
from pyros1.ground.errors import PackageNotFoundError
from pyros1.launch.running.command_line import executable_words, is_own, program_environment

_MAX_BYTES = 4 << 20
_TIMEOUT = 30.0
_STACK_SIZE = 512 << 20
"""Stack size in bytes for parsing: sufficient for the deepest expression that fits into _MAX_BYTES."""
_PYTHON2_ERRORS = (
    "Missing parentheses in call to",
    "multiple exception types must be",
    "inconsistent use of tabs",
    "invalid decimal literal",
    "leading zeros in decimal",
)
"""Beginnings of the messages of syntax errors that Python 3 reports for Python 2 programs."""
_CONVERSION_HINT = (
    "it looks like a program for Python 2: pip install fissix && fissix -w {} does most of the conversion"
)
_TOO_DEEP = "its expressions or blocks are nested too deeply for Python"
_OUR_PACKAGE = "pyros1"
_SEARCH_PROGRAM = """
import importlib.util, json, sys
wanted, missing = json.load(sys.stdin), []
for folder, name in wanted:
    sys.path.insert(0, folder)
    try:
        found = importlib.util.find_spec(name) is not None
    except (ImportError, ValueError):
        found = name in sys.modules
    del sys.path[0]
    if not found:
        missing.append([folder, name])
print()
print(json.dumps(missing))
"""
"""A program that prints which modules an interpreter cannot find, without importing them."""


class Import(NamedTuple):
    """An unconditional import in a program: it is executed on every run."""

    module: str
    line: int


class Problem(NamedTuple):
    """The reason why a file cannot be run."""

    file: Path
    text: str


def python_problems(files: Mapping[Path, Mapping[str, str]]) -> Iterator[Problem]:
    """Yield the problems that prevent programs from running. The programs are not executed.

    Args:
        files: executables with their environment variables. Programs that are not written in Python are skipped, and
            so are pyros1's own programs.
    """
    groups: dict[tuple[str, ...], dict[Path, list[Import]]] = {}
    for file, environ in files.items():
        python = _interpreter_words(file, environ)
        if not python:
            continue
        try:
            source = file.read_bytes()[:_MAX_BYTES]
        except OSError:
            continue
        try:
            found_imports = find_imports(source, str(file))
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            yield Problem(file, _syntax_problem(file, error))
        else:
            groups.setdefault((environ.get("PYTHONPATH", ""), *python), {})[file] = found_imports
    for (_, *words), group in groups.items():
        missing = _find_missing(words, group, files[next(iter(group))])
        for file, found_import in (
            (file, found_import) for file, file_imports in group.items() for found_import in file_imports
        ):
            if (str(file.resolve().parent), found_import.module) in missing:
                hint = _module_hint(found_import.module, files[file]) if ("", _OUR_PACKAGE) in missing else ""
                yield Problem(
                    file, f"{file}:{found_import.line}: {words[-1]} cannot find module {found_import.module}{hint}"
                )


def find_imports(source: bytes, name: str = "?") -> list[Import]:
    """Return the top-level modules that a program imports whenever it runs, without duplicates.

    Imports in functions and in ``try`` statements are ignored, as they may be optional.

    Args:
        source: the program's source code.
        name: name of the file, for error messages.

    Raises:
        SyntaxError, ValueError: the program is not valid Python 3.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tree = _parse(source, name)
    imports_by_module: dict[str, Import] = {}
    statements = list(tree.body)
    for statement in statements:
        if isinstance(statement, ast.If) and _mentions_dunder_name(statement.test):
            statements += statement.body
        elif isinstance(statement, ast.Import):
            for alias in statement.names:
                module = alias.name.partition(".")[0]
                imports_by_module.setdefault(module, Import(module, statement.lineno))
        elif isinstance(statement, ast.ImportFrom) and not statement.level and statement.module:
            module = statement.module.partition(".")[0]
            imports_by_module.setdefault(module, Import(module, statement.lineno))
    return list(imports_by_module.values())


def _parse(source: bytes, name: str) -> ast.Module:
    """Parse a program. Python 3.10, which does not limit the depth of nesting, could crash without a large stack.

    Raises:
        SyntaxError, ValueError, RecursionError, MemoryError: the program cannot be parsed.
    """
    if sys.version_info >= (3, 11):
        return ast.parse(source, name)
    results: list[ast.Module | Exception] = []

    def parse() -> None:
        try:
            results.append(ast.parse(source, name))
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            results.append(error)

    previous_size = threading.stack_size(_STACK_SIZE)
    try:
        thread = threading.Thread(target=parse)
        thread.start()
    finally:
        threading.stack_size(previous_size)
    thread.join()
    (result,) = results
    if isinstance(result, Exception):
        raise result
    return result


def _mentions_dunder_name(test: ast.expr) -> bool:
    return any(isinstance(node, ast.Name) and node.id == "__name__" for node in ast.walk(test))


def _interpreter_words(file: Path, environ: Mapping[str, str]) -> tuple[str, ...]:
    """Return the command line of a program's interpreter; empty if that is not Python 3, or the program is pyros1's."""
    if is_own(file):
        return ()
    try:
        with file.open("rb") as stream:
            first_line = stream.readline(256).decode(errors="replace")
    except OSError:
        return ()
    named_words = first_line[2:].split() if first_line.startswith("#!") else []
    if not any("python" in os.path.basename(word) for word in named_words) or any(
        "python2" in word for word in named_words
    ):
        return ()
    words = executable_words(file, environ)
    return (words[0],) if len(words) > 1 else tuple(word for word in named_words if not word.startswith("-"))


def _module_hint(module: str, environ: Mapping[str, str]) -> str:
    """Return a hint for an interpreter without pyros1 that cannot find one of its modules; empty for other modules."""
    if module != _OUR_PACKAGE and not os.path.isdir(os.path.join(MODULES_FOLDER, module)):
        try:
            PackageIndex(environ).find(module)
        except PackageNotFoundError:
            return ""
    activate = os.path.join(os.path.dirname(sys.executable), "activate")
    activate_hint = f"activate pyros1's environment first (source {activate}), or " if os.path.isfile(activate) else ""
    return f": {activate_hint}write #!{sys.executable} as the program's first line"


def _syntax_problem(file: Path, error: BaseException) -> str:
    line = f":{error.lineno}" if isinstance(error, SyntaxError) and error.lineno else ""
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    if isinstance(error, (RecursionError, MemoryError)):
        text = _TOO_DEEP
    hint = f"; {_CONVERSION_HINT.format(file)}" if text.startswith(_PYTHON2_ERRORS) else ""
    return f"{file}{line}: {text}{hint}"


def _find_missing(
    python: list[str], files: Mapping[Path, list[Import]], environ: Mapping[str, str]
) -> set[tuple[str, str]]:
    """Return (folder of the program, module) for each imported module that an interpreter cannot find."""
    modules = sorted(
        {
            (str(file.resolve().parent), found_import.module)
            for file, imports in files.items()
            for found_import in imports
        }
    )
    env = {**environ, **program_environment(next(iter(files)), environ)}
    try:
        result = subprocess.run(
            [*python, "-c", _SEARCH_PROGRAM],
            env=env,
            input=json.dumps([*modules, ("", _OUR_PACKAGE)]).encode(),  # there may be too many modules for an argument
            capture_output=True,
            timeout=_TIMEOUT,
            check=True,
        )
        return {(folder, module) for folder, module in json.loads(result.stdout.splitlines()[-1])}
    except (OSError, subprocess.SubprocessError, ValueError, IndexError):
        return set()  # the interpreter cannot be started, which is reported elsewhere
