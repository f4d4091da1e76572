"""Writes stub files (.pyi) for message and service classes, for use by editors and type checkers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from pyros1.finding.library import SHIPPED_DEFINITIONS, Library
from pyros1.ground.errors import UnknownTypeError
from pyros1.ground.msgs_imports import module_name
from pyros1.msgs.stubs import message_stub, package_stub, service_stub, used_packages

STUBS_FOLDER = Path(SHIPPED_DEFINITIONS).parent
"""Folder of the stubs for the definitions that come with pyros1: the folder of ``pyros1.msgs``."""


def generate_stubs(library: Library, packages: Iterable[str]) -> Iterator[tuple[Path, str]]:
    """Yield (path, text) of the stub files for packages; paths are relative to the folder of ``pyros1.msgs``.

    Args:
        library: the source of the definitions.
        packages: names of packages.

    Raises:
        UnknownTypeError: there is no such package.
        DefinitionError: a definition is invalid; the message names the file and the line.
    """
    for package in packages:
        if not library.has_package(package):
            raise UnknownTypeError(library.missing_package_message(package))
        folder = Path(module_name(package))
        messages = [library.message(f"{package}/{short_name}") for short_name in library.messages(package)]
        services = [library.service(f"{package}/{short_name}") for short_name in library.services(package)]
        yield folder / "__init__.pyi", package_stub(package)
        if messages:
            yield folder / "msg.pyi", message_stub(package, messages)
        if services:
            yield folder / "srv.pyi", service_stub(package, services)


def required_packages(library: Library, package: str) -> set[str]:
    """Return the existing packages whose messages are the types of fields in a package's definitions.

    Raises:
        DefinitionError: a definition is invalid; the message names the file and the line.
    """
    specs = [library.message(f"{package}/{short_name}") for short_name in library.messages(package)]
    for short_name in library.services(package):
        service = library.service(f"{package}/{short_name}")
        specs += [service.request, service.response]
    return {name for spec in specs for name in used_packages(spec) if library.has_package(name)}


def shipped_library() -> Library:
    """Return a library with only the definitions that come with pyros1."""
    return Library({}, installs=())


def write_stubs(files: Iterable[tuple[Path, str]], folder: Path) -> list[Path]:
    """Write the files that do not exist in ``folder`` or have a different text there; return the paths that were
    written.

    Raises:
        OSError: a file cannot be written.
    """
    written = []
    for name, text in files:
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
            written.append(path)
    return written
