"""``msg stubs``: writes type stubs of messages and services for editors and type checkers."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.cli.shared.definitions import library
from pyros1.ground.errors import MessageError


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write stubs for packages next to the stubs that pyros1 provides, where editors and type checkers find them."""
    from pyros1.finding import stubs  # noqa: PLC0415 - not needed for help

    packages = list(dict.fromkeys(args or library().packages()))
    shipped_library = stubs.shipped_library()
    written_files, errors = [], []
    try:
        for package in packages:  # the loop appends the packages whose types these packages use
            try:
                written_files += stubs.write_stubs(stubs.generate_stubs(library(), [package]), stubs.STUBS_FOLDER)
                used_packages = sorted(stubs.required_packages(library(), package))
                packages += [
                    name for name in used_packages if name not in packages and not shipped_library.has_package(name)
                ]
            except MessageError as error:
                errors.append(str(error))
    except OSError as error:
        raise CommandError(
            f"cannot write {error.filename or stubs.STUBS_FOLDER}: {error.strerror}. "
            "Stubs are written to the installed pyros1: install it where you have write permission, for example in a "
            "virtual environment"
        ) from None
    written_packages = {path.parent.name for path in written_files}
    count = len(packages) - len(errors)
    if count or not errors:
        print(
            f"{count} package{'s' * (count != 1)}, {len(written_packages)} new or changed, in {stubs.STUBS_FOLDER}",
            flush=True,
        )
    if errors:
        raise CommandError("\nERROR: ".join(errors))


VERB = Verb(
    "stubs",
    "write type stubs of messages and services for editors and type checkers",
    Argument("package", "package", repeatable=True, optional=True),
    description="Write stubs (.pyi) for the given packages and for the packages whose messages they use. "
    "Without a package, write stubs for all packages. The stubs are written to the installed pyros1, where editors and "
    "type checkers find them. The packages that come with pyros1 already have stubs.",
    examples=[
        ("my_robot", "let mypy, pyright and editors check: from pyros1.msgs.my_robot.msg import State"),
        ("", "write stubs for all packages, for example after a change"),
    ],
    stock="",
    run=run,
)
