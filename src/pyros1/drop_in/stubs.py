"""Writes stub-only packages (PEP 561) for the drop-in modules under stock names, for type checkers and editors."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from pyros1.drop_in.finder import MODULES_FOLDER
from pyros1.finding.library import Library
from pyros1.finding.stubs import shipped_library
from pyros1.ground.errors import MessageError
from pyros1.ground.msgs_imports import MSGS_PACKAGE, module_name
from pyros1.msgs.stubs import message_stub, service_stub

_MODULES_PACKAGE = "pyros1.drop_in.modules"


def write_stubs(folder: Path, library: Library) -> list[str]:
    """Write stubs for pyros1's modules and for all message packages, replacing existing ones.

    Args:
        folder: a folder that contains nothing but stubs; it is emptied.
        library: the message packages.

    Returns:
        An error message for each package that has no stubs because one of its definitions is invalid.

    Raises:
        OSError: a file cannot be written.
    """
    if folder.is_dir():
        shutil.rmtree(folder)
    errors = []
    our_library = shipped_library()
    for package in library.packages():
        try:
            _write_files(
                folder / f"{package}-stubs", _shipped_stubs(our_library, package) or _message_stubs(library, package)
            )
        except MessageError as error:
            errors.append(str(error))
    _write_files(folder, dict(_module_stubs()))
    return errors


def _write_files(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def _module_stubs() -> Iterator[tuple[str, str]]:
    """Yield stubs that import pyros1's modules, which contain type annotations."""
    for source in sorted(Path(MODULES_FOLDER).rglob("*.py")):
        package, *submodules = PurePosixPath(source.relative_to(MODULES_FOLDER)).with_suffix("").parts
        name = ".".join([package, *(part for part in submodules if part != "__init__")])
        yield "/".join([f"{package}-stubs", *submodules]) + ".pyi", f"from {_MODULES_PACKAGE}.{name} import *\n"


def _shipped_stubs(our_library: Library, package: str) -> dict[str, str]:
    """Return stubs that import the ones of ``pyros1.msgs``; an empty dict for a package that is not part of pyros1."""
    if not our_library.has_package(package):
        return {}
    kinds = [("msg", our_library.messages(package)), ("srv", our_library.services(package))]
    texts = {kind: f"from {MSGS_PACKAGE}.{module_name(package)}.{kind} import *\n" for kind, names in kinds if names}
    return _package_files(texts)


def _message_stubs(library: Library, package: str) -> dict[str, str]:
    messages = [library.message(f"{package}/{short}") for short in library.messages(package)]
    services = [library.service(f"{package}/{short}") for short in library.services(package)]
    texts = {"msg": message_stub(package, messages, True)} if messages else {}
    return _package_files(texts | ({"srv": service_stub(package, services, True)} if services else {}))


def _package_files(texts: dict[str, str]) -> dict[str, str]:
    files = {f"{kind}.pyi": text for kind, text in texts.items()}
    return {"__init__.pyi": "", "py.typed": "partial\n", **files}  # "partial", as the package may have other modules
