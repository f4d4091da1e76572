"""Message classes that genpy has generated: modules of a catkin devel or install space that a program imports.

Such a class derives from `Message`, and has fields, types, md5 and code of its own, but none of the attributes from
which pyros1 generates codecs. They are derived from its fields.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from pyros1.ground.errors import DefinitionError
from pyros1.msgs.base import Message
from pyros1.msgs.factory import measure
from pyros1.msgs.spec import BUILTINS, parse_field


def adopt(cls: Any) -> None:
    """Set the attributes that a generated class lacks.

    Args:
        cls: the class.

    Raises:
        DefinitionError: a type of its fields cannot be imported.
    """
    fields = [parse_field(name, kind) for name, kind in zip(cls.__slots__, cls._slot_types, strict=True)]
    classes = {field.base: _imported(field.base, cls._type) for field in fields if field.base not in BUILTINS}
    sizes = [measure(field, classes) for field in fields]
    minimum = sum(size for size, _, _ in sizes)
    cls._classes = classes
    cls._min_size = minimum
    cls._weight = sum(weight for _, weight, _ in sizes)
    cls._fixed_size = minimum if all(fixed for _, _, fixed in sizes) else None


def _imported(name: str, owner: str) -> type[Message]:
    package, _, short = name.partition("/")
    try:
        found = getattr(import_module(f"{package}.msg"), short)
    except (ImportError, AttributeError) as error:
        raise DefinitionError(f"the class of {name} cannot be imported: {error}", owner) from error
    if not issubclass(found, Message):
        raise DefinitionError(f"the class of {name} is not a message class", owner)
    made: type[Message] = found
    return made
