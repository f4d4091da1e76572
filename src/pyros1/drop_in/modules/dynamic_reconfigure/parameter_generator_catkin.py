"""ParameterGenerator, with which ``.cfg`` files describe parameters.

pyros1 needs no build: ``from my_package.cfg import TutorialsConfig`` runs ``cfg/Tutorials.cfg`` of that ROS package.
"""

from __future__ import annotations

import inspect
import os
import re
import sys
from typing import Any

from pyros1.drop_in import cfg_modules
from pyros1.reconfigure.description import Group, Parameters, check_type

str_t = "str"
bool_t = "bool"
int_t = "int"
double_t = "double"
id = 0
LINEDEBUG = "//#line"

_INFINITY = float("inf")
_C_TYPES = {
    "bool": {"ctype": "bool", "cconsttype": "const bool"},
    "int": {"ctype": "int", "cconsttype": "const int"},
    "double": {"ctype": "double", "cconsttype": "const double"},
    "str": {"ctype": "std::string", "cconsttype": "const char * const"},
}
_PYTHON_TYPES = {"str": str, "int": int, "double": float, "bool": bool}


def check_description(description: Any) -> None:
    """Raise ValueError if a description contains quotes, which stock's generated C++ code does not allow."""
    if '"' in description:
        raise ValueError(f"quotes not allowed in description string `{description}`")


def check_name(name: str) -> None:
    """Raise ValueError for a name that is not legal."""
    if not re.fullmatch(r"[a-zA-Z]\w*", name, re.ASCII):
        raise ValueError(
            f"The name of field '{name}' does not follow the ROS naming conventions, "
            "see http://wiki.ros.org/ROS/Patterns/Conventions"
        )


def _call_location() -> dict[str, Any]:
    """Return the line and the file of the call in a .cfg file."""
    frame = inspect.currentframe()
    while frame is not None and frame.f_code.co_filename == __file__:
        frame = frame.f_back
    line, file = (frame.f_lineno, frame.f_code.co_filename) if frame is not None else (0, "")
    return {"srcline": line, "srcfile": os.path.basename(file)}


class ParameterGenerator:
    """Collects the parameters, groups, enums and constants that a ``.cfg`` file describes."""

    minval = {"int": -(2**31), "double": -_INFINITY, "str": "", "bool": False}
    maxval = {"int": 2**31 - 1, "double": _INFINITY, "str": "", "bool": True}
    defval = {"int": 0, "double": 0, "str": "", "bool": False}

    class Group:
        """A group of parameters."""

        def __init__(self, gen: ParameterGenerator, group: Group) -> None:
            self.gen = gen
            self._group = group
            self.name, self.type, self.state, self.id = group.name, group.type, group.state, group.id
            self.parent = group.parent.id if group.parent is not None else 0
            self.parameters = group.parameters

        def add(
            self,
            name: str,
            paramtype: str,
            level: int,
            description: str,
            default: Any = None,
            min: Any = None,
            max: Any = None,
            edit_method: str = "",
        ) -> None:
            """Add a parameter.

            Args:
                name: name of the parameter.
                paramtype: str_t, int_t, double_t or bool_t.
                level: bits to pass to the callback when the parameter changes.
                description: a human-readable description.
                default, min, max: values of the type; None for defaults.
                edit_method: the result of `enum`; empty if there are no choices.
            """
            self.gen.pytype(paramtype)
            parameter = self._group.add(
                name,
                default,
                description,
                type=paramtype,
                minimum=min,
                maximum=max,
                level=level,
                edit_method=edit_method,
            )
            parameter.update(_call_location(), **_C_TYPES[paramtype])

        def add_group(self, name: str, type: str = "", state: bool = True) -> ParameterGenerator.Group:
            """Add a group below this one, and return it."""
            check_name(name.replace(" ", "_"))
            group = self.gen.parameters.group(name.replace(" ", "_"), type, state, self._group)
            return type_of(self)(self.gen, group)

        def get_group(self) -> Any:
            """Return the number of this group."""
            return self.id

        def get_parameters(self) -> list[dict[str, Any]]:
            """Return the parameters of this group and of all groups below it."""
            return [parameter for group in self._group.all_groups() for parameter in group.parameters]

        def to_dict(self) -> dict[str, Any]:
            """Return the group as a description."""
            return self._group.as_dict()

    def __init__(self) -> None:
        self.parameters = Parameters()
        self.group = self.Group(self, self.parameters)
        self.constants: list[dict[str, Any]] = []

    def pytype(self, drtype: str) -> type:
        """Return the Python type of a parameter type."""
        return _PYTHON_TYPES[drtype]

    def check_type(self, param: dict[str, Any], field: str) -> None:
        """Convert a value to the type of its parameter or constant; raise TypeError if it does not fit."""
        param[field] = check_type(param["name"], param["type"], field, param[field])

    def fill_type(self, param: dict[str, Any]) -> None:
        """Add the names of the C++ types."""
        param.update(_C_TYPES[param["type"]])

    def check_type_fill_default(self, param: dict[str, Any], field: str, default: Any) -> None:
        """Replace None with a default, which is not validated; validate other values."""
        if param[field] is None:
            param[field] = default
        else:
            self.check_type(param, field)

    def const(self, name: str, type: str, value: Any, descr: str) -> dict[str, Any]:
        """Add a constant to the module, and return it for use in `enum`."""
        self.pytype(type)
        constant = {"name": name, "type": type, "value": check_type(name, type, "value", value), **_call_location()}
        constant.update(description=descr, **_C_TYPES[type])
        check_description(descr)
        self.constants.append(constant)
        return constant

    def enum(self, constants: list[dict[str, Any]], description: str) -> str:
        """Return a choice of constants, to pass to `add` as ``edit_method``."""
        if len({constant["type"] for constant in constants}) != 1:
            raise Exception("Inconsistent types in enum!")
        return repr({"enum": constants, "enum_description": description})

    def add(
        self,
        name: str,
        paramtype: str,
        level: int,
        description: str,
        default: Any = None,
        min: Any = None,
        max: Any = None,
        edit_method: str = "",
    ) -> None:
        """Add a parameter; see `Group.add`."""
        self.group.add(name, paramtype, level, description, default, min, max, edit_method)

    def add_group(self, name: str, type: str = "", state: bool = True) -> ParameterGenerator.Group:
        """Add a group, and return it."""
        return self.group.add_group(name, type=type, state=state)

    def generate(self, pkgname: str, nodename: str, name: str) -> int:
        """Finish the description, which is passed to the module that is being imported.

        Raises:
            NotImplementedError: the file is run as a program; pyros1 does not generate files, and does not need them.
        """
        cfg_modules.add_description(self.module_contents(name))
        return 0

    def module_contents(self, name: str) -> dict[str, Any]:
        """Return the contents of the module ``NAMEConfig``."""
        parameters = self.group.get_parameters()
        contents: dict[str, Any] = {
            "inf": _INFINITY,
            "config_description": self.group.to_dict(),
            "all_level": self.parameters.all_level,
        }
        for key, field in (
            ("min", "min"),
            ("max", "max"),
            ("defaults", "default"),
            ("level", "level"),
            ("type", "type"),
        ):
            contents[key] = {parameter["name"]: parameter[field] for parameter in parameters}
        return contents | {f"{name}_{constant['name']}": constant["value"] for constant in self.constants}

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"pyros1 has no dynamic_reconfigure ParameterGenerator.{name}: it generates no files")


type_of = type
