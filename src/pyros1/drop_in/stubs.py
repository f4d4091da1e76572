"""Writes stubs with stock's names, for type checkers and editors (PEP 561, stub-only packages)."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from pyros1.drop_in.finder import MODULES
from pyros1.finding.library import Library
from pyros1.finding.stubs import shipped_library
from pyros1.ground.errors import MessageError
from pyros1.ground.generated import MSGS_PACKAGE, module_name
from pyros1.msgs.stubs import message_stub, service_stub

_HERE = "pyros1.drop_in.modules"


def write_stubs(folder: Path, library: Library) -> list[str]:
    """Write stubs for pyros1's modules and for all message packages, replacing existing ones.

    Args:
        folder: a folder that contains nothing but stubs; it is emptied.
        library: the message packages.

    Returns:
        An error message for each package without stubs, because a definition is invalid.

    Raises:
        OSError: a file cannot be written.
    """
    if folder.is_dir():
        shutil.rmtree(folder)
    errors = []
    our_stubs = shipped_library()
    for package in library.packages():
        try:
            _write(folder / f"{package}-stubs", _shipped(our_stubs, package) or _messages(library, package))
        except MessageError as error:
            errors.append(str(error))
    _write(folder, dict(_modules()))
    return errors


def _write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def _modules() -> Iterator[tuple[str, str]]:
    """Yield stubs that import pyros1's modules, which contain type annotations."""
    for source in sorted(Path(MODULES).rglob("*.py")):
        top, *rest = PurePosixPath(source.relative_to(MODULES)).with_suffix("").parts
        name = ".".join([top, *(part for part in rest if part != "__init__")])
        yield "/".join([f"{top}-stubs", *rest]) + ".pyi", f"from {_HERE}.{name} import *\n"


def _shipped(our_stubs: Library, package: str) -> dict[str, str]:
    """Return stubs that import those of ``pyros1.msgs``; an empty dict for a package that is not part of pyros1."""
    if not our_stubs.has_package(package):
        return {}
    kinds = [("msg", our_stubs.messages(package)), ("srv", our_stubs.services(package))]
    texts = {kind: f"from {MSGS_PACKAGE}.{module_name(package)}.{kind} import *\n" for kind, names in kinds if names}
    return _package(texts)


def _messages(library: Library, package: str) -> dict[str, str]:
    messages = [library.message(f"{package}/{short}") for short in library.messages(package)]
    services = [library.service(f"{package}/{short}") for short in library.services(package)]
    texts = {"msg": message_stub(package, messages, True)} if messages else {}
    return _package(texts | ({"srv": service_stub(package, services, True)} if services else {}))


def _package(texts: dict[str, str]) -> dict[str, str]:
    files = {f"{kind}.pyi": text for kind, text in texts.items()}
    return {"__init__.pyi": "", "py.typed": "partial\n", **files}  # "partial", as the package may have other modules
