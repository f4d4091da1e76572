"""Chooses legal names for types that a ROS 2 distribution does not have; ROS 2's readers reject illegal names.

The rules are the same as for ROS 2's interface definitions
(https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html): packages and fields are in lower case with single
underscores, types in camel case. So ``Mocap`` becomes ``mocap``, ``timeStamp`` becomes ``time_stamp``, ``my_type``
becomes ``MyType``. If the new name is already in use, a number is added. Does no I/O.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Container
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.interfaces.typing import Typesdict

_LOWER_NAME = re.compile(r"[a-z](_?[a-z0-9])*")
_TYPE_NAME = re.compile(r"[A-Z][A-Za-z0-9]*")
_CONSTANT_NAME = re.compile(r"[A-Z](_?[A-Z0-9])*")
_WORD_PATTERN = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z0-9]+|[0-9]+")


class LegalNames:
    """Maps the names of types and fields to names that ROS 2 allows.

    Args:
        distribution_types: names of the ROS 2 distribution's types, which are not renamed and keep their field names.

    Attributes:
        renamed: old name, for example ``package Mocap`` or ``field a/b.timeStamp`` -> new name.
    """

    def __init__(self, distribution_types: Container[str]) -> None:
        self.renamed: dict[str, str] = {}
        self._distribution_types = distribution_types
        self._packages: dict[str, str] = {}
        self._types: dict[str, str] = {}

    def legal_type(self, name: str) -> str:
        """Return the new name of a type: ``mocap/msg/Frame`` for ``Mocap/msg/Frame``."""
        if name in self._distribution_types:
            return name
        legal = self._types.get(name)
        if legal is None:
            package, folder, short = name.split("/")
            package = self._legal_name(self._packages, package, _LOWER_NAME, _snake_case, f"package {package}")
            package_types = {
                old: new.rpartition("/")[2] for old, new in self._types.items() if new.startswith(f"{package}/")
            }
            legal = (
                f"{package}/{folder}/{self._legal_name(package_types, short, _TYPE_NAME, _camel_case, f'type {name}')}"
            )
            while legal in self._distribution_types:
                legal += "1"
            self._types[name] = legal
        return legal

    def legal_types(self, types: Typesdict) -> Typesdict:
        """Return the types with names that ROS 2 allows, for the types and for their fields and constants."""
        # Names that are already legal come first, so that they do not change.
        for name in sorted(types, key=lambda name: not _is_legal(name)):
            self.legal_type(name)
        return {
            self.legal_type(name): definition
            if name in self._distribution_types
            else self._legal_definition(name, *definition)
            for name, definition in types.items()
        }

    def _legal_definition(self, name: str, constants: Any, fields: Any) -> tuple[Any, Any]:
        ros1_name = name.replace("/msg/", "/")
        field_names = self._legal_names([field for field, _ in fields], _LOWER_NAME, _snake_case, f"field {ros1_name}.")
        constant_names = self._legal_names(
            [constant for constant, *_ in constants],
            _CONSTANT_NAME,
            _upper_snake_case,
            f"constant {ros1_name}.",
        )
        return (
            [(constant_names[constant], *rest) for constant, *rest in constants],
            [(field_names[field], self._field_type(type_node)) for field, type_node in fields],
        )

    def _field_type(self, type_node: Any) -> Any:
        """Return a field's type with legal names; the type may be a list of other types."""
        node_type, nested = type_node
        if node_type == Nodetype.NAME:
            return node_type, self.legal_type(nested)
        if node_type in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            return node_type, (self._field_type(nested[0]), nested[1])
        return type_node

    def _legal_names(
        self, names: Collection[str], rule: re.Pattern[str], convert: Callable[[str], str], label: str
    ) -> dict[str, str]:
        legal: dict[str, str] = {name: name for name in names if rule.fullmatch(name)}
        return {name: self._legal_name(legal, name, rule, convert, label + name) for name in names}

    def _legal_name(
        self, names: dict[str, str], name: str, rule: re.Pattern[str], convert: Callable[[str], str], label: str
    ) -> str:
        """Return the new name from `names`, choosing and adding one if there is none yet."""
        if name not in names:
            used_names = set(names.values())
            base_name = legal = name if rule.fullmatch(name) else convert(name)
            number = 2
            while legal in used_names:
                legal, number = f"{base_name}{number}", number + 1
            names[name] = legal
            if legal != name:
                self.renamed[label] = legal
        return names[name]


def _is_legal(name: str) -> bool:
    package, _, short = name.split("/")
    return _LOWER_NAME.fullmatch(package) is not None and _TYPE_NAME.fullmatch(short) is not None


def _snake_case(name: str) -> str:
    text = "_".join(_WORD_PATTERN.findall(name)).lower()
    return text if text[:1].isalpha() else f"x_{text}" if text else "x"


def _upper_snake_case(name: str) -> str:
    return _snake_case(name).upper()


def _camel_case(name: str) -> str:
    text = "".join(word[0].upper() + word[1:] for word in _WORD_PATTERN.findall(name))
    return text if text[:1].isalpha() else f"X{text}"
