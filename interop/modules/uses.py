"""Which names the test programs use, by the modules that they import: from their syntax trees, not their words.

Programs in strings count, too: a string of several lines, or with a call or an import, that Python can read.
"""

from __future__ import annotations

import ast
import textwrap
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path


def used_names(files: Iterable[Path], modules: Iterable[str]) -> dict[str, set[str]]:
    """Return, by module, the names that occur in files that import it, or name it as ``package.module``."""
    wanted = list(modules)
    found: dict[str, set[str]] = {module: set() for module in wanted}
    for file in files:
        nodes = list(_nodes(file.read_text(encoding="utf-8")))
        names = {name for node in nodes for name in _names(node)}
        imported = {name for node in nodes for name in _imported(node)}
        for module in wanted:
            if module in imported:
                found[module] |= names
    return found


def _nodes(text: str) -> Iterator[ast.AST]:
    """Yield the nodes of a program, and of those in its strings."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of invalid escapes
            tree = ast.parse(textwrap.dedent(text))
    except (SyntaxError, ValueError):
        return
    for node in ast.walk(tree):
        yield node
        if isinstance(node, ast.JoinedStr):
            inner = "".join(str(part.value) if isinstance(part, ast.Constant) else "x" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            inner = node.value
        else:
            continue
        if any(sign in inner for sign in ("\n", "(", "import ")):
            yield from _nodes(inner)


def _names(node: ast.AST) -> Iterator[str]:
    """Yield the names that a node uses; a method that is defined may replace that of a base class."""
    match node:
        case ast.Attribute(attr=name) | ast.Name(id=name) | ast.FunctionDef(name=name):
            yield name
        case ast.Import(names=aliases) | ast.ImportFrom(names=aliases):
            yield from (part for alias in aliases for part in alias.name.split("."))


def _imported(node: ast.AST) -> Iterator[str]:
    """Yield the modules that a node imports, with the packages that these are in, or names in full."""
    match node:
        case ast.Import(names=aliases):
            for alias in aliases:
                yield from _with_packages(alias.name)
        case ast.ImportFrom(module=str(module), names=aliases):
            yield from _with_packages(module)
            yield from (f"{module}.{alias.name}" for alias in aliases)
        case ast.Attribute():
            yield ast.unparse(node)


def _with_packages(module: str) -> Iterator[str]:
    parts = module.split(".")
    yield from (".".join(parts[: end + 1]) for end in range(len(parts)))
