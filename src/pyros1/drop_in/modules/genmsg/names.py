"""Names of messages and services: ``package/Type``."""

from __future__ import annotations

import re

from pyros1.drop_in.module_attributes import module_getattr

PRN_SEPARATOR = "/"
RESOURCE_NAME_LEGAL_CHARS_P = re.compile(r"^[A-Za-z][\w_\/]*$")
BASE_RESOURCE_NAME_LEGAL_CHARS_P = re.compile(r"^[A-Za-z][\w_]*$")

__getattr__ = module_getattr(__name__)


def normalize_package_context(package_context: str) -> str:
    """Return a package's name without trailing slashes."""
    return package_context.strip().rstrip(PRN_SEPARATOR)


def package_resource_name(name: str) -> tuple[str, str]:
    """Return a name's package and short name; the package is empty if the name has none.

    Raises:
        ValueError: there are two slashes.
    """
    if name.count(PRN_SEPARATOR) > 1:
        raise ValueError(f"invalid name [{name}]")
    package, slash, short = name.partition(PRN_SEPARATOR)
    return (package, short) if slash else ("", name)


def resource_name(res_pkg_name: str, name: str, my_pkg: str | None = None) -> str:
    """Return a full name, or just the short name if the package is ``my_pkg``."""
    if res_pkg_name == my_pkg or not res_pkg_name:
        return name
    return f"{res_pkg_name}{PRN_SEPARATOR}{name}"


def resource_name_base(name: str) -> str:
    """Return the short name."""
    return name.rpartition(PRN_SEPARATOR)[2]


def resource_name_package(name: str) -> str | None:
    """Return the package; None if the name has none."""
    return name.partition(PRN_SEPARATOR)[0] if PRN_SEPARATOR in name else None


def is_legal_resource_name(name: str | None) -> bool:
    """Return whether a name, with or without a package, is legal."""
    return bool(name) and RESOURCE_NAME_LEGAL_CHARS_P.match(str(name)) is not None and "//" not in str(name)


def is_legal_resource_base_name(name: str | None) -> bool:
    """Return whether a short name is legal."""
    return name is not None and BASE_RESOURCE_NAME_LEGAL_CHARS_P.match(name) is not None
