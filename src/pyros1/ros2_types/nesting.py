"""Finds the types that a type uses, and stacks collections of types. No I/O."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.ros2_types.model import MessageType, Types

_MAX_DEPTH = 64


class LayeredTypes(Mapping[str, MessageType]):
    """Several collections of types as one.

    Only the types that are needed are looked up, since some collections, such as a distribution's, convert types on
    access.

    Args:
        layers: the collections; earlier ones take precedence.
    """

    def __init__(self, *layers: Types) -> None:
        self._layers = layers

    def __getitem__(self, name: str) -> MessageType:
        for layer in self._layers:
            if name in layer:
                return layer[name]
        raise KeyError(name)

    def __contains__(self, name: object) -> bool:
        return any(name in layer for layer in self._layers)

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys(name for layer in self._layers for name in layer))

    def __len__(self) -> int:
        return sum(1 for _ in self)


def find_type(name: str, types: Types) -> MessageType:
    """Return a type.

    Raises:
        UnknownTypeError: it is not in `types`.
    """
    try:
        return types[name]
    except KeyError:
        raise UnknownTypeError(f"the definition of the ROS 2 type [{name}] is missing") from None


def all_types(names: Iterable[str], types: Types, *, may_miss: bool = False) -> list[str]:
    """Return types and all types that they use, each once, and each after the types that it uses.

    Args:
        names: full names of the types.
        types: contains the types.
        may_miss: whether to leave out types that are not in `types`.

    Raises:
        UnknownTypeError: a type is missing.
        DefinitionError: a type contains itself, or is nested more than 64 deep.
    """
    depths: dict[str, int] = {}
    for root in names:
        # Without recursion, since definitions come from peers, and may be nested to any depth.
        path: dict[str, Iterator[str]] = {}
        name: str | None = root
        while True:
            if name is not None and name not in depths and not (may_miss and name not in types):
                if name in path:
                    raise DefinitionError(f"the type contains itself: {_circle(list(path), name)}", name)
                path[name] = iter(_used_types(find_type(name, types)))
            if not path:
                break
            current = next(reversed(path))
            name = next(path[current], None)
            if name is None:
                del path[current]
                used = [depths[each] for each in _used_types(types[current]) if each in depths]
                depths[current] = 1 + max(used, default=0)
                if depths[current] > _MAX_DEPTH:
                    raise DefinitionError(f"nested more than {_MAX_DEPTH} deep", current)
    return list(depths)


def _used_types(message_type: MessageType) -> list[str]:
    return list(dict.fromkeys(field.type.base for field in message_type.fields if field.type.is_nested))


def _circle(path: list[str], name: str) -> str:
    return " -> ".join([*path[path.index(name) :], name])
