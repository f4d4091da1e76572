"""Message classes from the definitions in connection headers and bags."""

from __future__ import annotations

import itertools
import sys
from types import ModuleType
from typing import Any

from genmsg.base import InvalidMsgSpec, MsgGenerationException

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.errors import DefinitionError
from pyros1.msgs import from_definition
from pyros1.msgs.base import nested_classes
from pyros1.msgs.digest import SEPARATOR, split_full_text

__all__ = ["MsgGenerationException", "generate_dynamic"]

__getattr__ = module_getattr(__name__)
_module_numbers = itertools.count(1)


def generate_dynamic(core_type: str, msg_cat: str) -> dict[str, type[Any]]:
    """Return classes for a message type and for all types that it uses.

    Args:
        core_type: the type, ``package/Type``.
        msg_cat: the full text: its definition, and the definitions of all types that it uses.

    Returns:
        Full type name -> class.

    Raises:
        InvalidMsgSpec: a definition in ``msg_cat`` is invalid.
        MsgGenerationException: ``msg_cat`` lacks the definition of a type, or no classes can be created from it.
    """
    classes: dict[str, type[Any]] = {}
    try:
        _collect(core_type, from_definition(core_type, msg_cat), classes)
        for name, text in split_full_text(core_type, msg_cat).items():
            name = "std_msgs/Header" if name == "roslib/Header" else name  # noqa: PLW2901
            if name not in classes:  # the message does not use this type
                _collect(name, from_definition(name, f"{text}\n{SEPARATOR}\nMSG: {core_type}\n{msg_cat}"), classes)
    except DefinitionError as error:
        raise (MsgGenerationException if error.line is None else InvalidMsgSpec)(str(error)) from error
    make_importable(classes)
    return classes


def make_importable(classes: dict[str, type[Any]]) -> None:
    """Put classes, and the classes that they use, into modules, so that this process and its forks can pickle messages.

    Args:
        classes: full type name -> class.
    """
    number = next(_module_numbers)
    all_classes: dict[str, type[Any]] = {}
    for name, cls in classes.items():
        _collect(name, cls, all_classes)
    for name, cls in all_classes.items():
        module = f"_pyros1_definitions_{number}_{name.partition('/')[0]}"
        setattr(sys.modules.setdefault(module, ModuleType(module)), cls.__qualname__, cls)
        cls.__module__ = module


def _collect(name: str, cls: type[Any], classes: dict[str, type[Any]]) -> None:
    if name not in classes:
        classes[name] = cls
        for nested_name, nested_class in nested_classes(cls).items():
            _collect(nested_name, nested_class, classes)
