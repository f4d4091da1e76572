"""Reads YAML by ROS 1's rules: with PyYAML's safe loader, as in stock ROS, and four notations for angles.

The notations for angles are ``deg(90)``, ``rad(pi/2)``, ``!degrees 90`` and ``!radians pi/2``
(https://wiki.ros.org/rosparam#YAML_Format). YAML text cannot create any other Python objects: the only values are None,
bool, int, float, str, bytes, date, datetime, list, dict and set.

This adds to PyYAML: angles; limits, since a few hundred bytes of text can represent billions of values or keep PyYAML
busy for minutes; errors with file and line; and a shortcut for single words and numbers, since importing PyYAML takes
longer than most commands.
"""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Any

from pyros1.ground.errors import Error

_MAX_DEPTH = 50
"""Maximum nesting depth: each level needs several nested calls, which Python limits."""
_MAX_COPIED_VALUES = 50_000
"""Maximum total number of values that aliases and merge keys can represent; long strings count more than once."""
_CHARACTERS_PER_VALUE = 100
"""Number of characters of a string that count as one value for `_MAX_COPIED_VALUES`."""
_MAX_INTEGER_DIGITS = 200
"""Maximum number of characters of an integer: no field can store more than 64 bits, and Python is slow with thousands
of digits."""
_MAX_QUOTED_LENGTH = 60
"""Maximum number of characters of an invalid value quoted in an error message."""

ANGLE_TAGS = {"!degrees": (re.compile(r"deg\([^)]*\)\Z"), "d"), "!radians": (re.compile(r"rad\([^)]*\)\Z"), "r")}
"""Tag for angles -> pattern of the plain scalars that have this tag, and the character with which they begin."""
_SCALAR_TAGS = frozenset(
    [
        *ANGLE_TAGS,
        *(f"tag:yaml.org,2002:{name}" for name in ("null", "bool", "int", "float", "str", "binary", "timestamp")),
    ]
)
"""Tags of single values."""

# Values that can be parsed without PyYAML; most parameters on a command line are of this kind.
_SIMPLE_WORD = re.compile(r"[A-Za-z_/][\w/.-]*", re.ASCII)
_SIMPLE_INT = re.compile(r"-?(?:0|[1-9][0-9]{0,17})")
_SIMPLE_FLOAT = re.compile(r"-?[0-9]+\.[0-9]+")
_SPECIAL_WORDS = frozenset(("yes", "no", "true", "false", "on", "off", "null"))


class YamlError(Error, ValueError):
    """The given text is not valid YAML, or exceeds a limit.

    Args:
        message: what is wrong.
        where: file name or other origin; None if unknown.
        line: 1-based line number; None if unknown.
    """

    def __init__(self, message: str, where: str | None = None, line: int | None = None) -> None:
        self.where = where
        self.line = line
        location = f"{where or '<yaml>'}:{line}: " if line is not None else f"{where}: " if where else ""
        super().__init__(location + message)


def parse_simple_value(text: str) -> str | int | float | None:
    """Return the value of a single word or number that does not need PyYAML, or None for any other text."""
    if _SIMPLE_WORD.fullmatch(text) and text.lower() not in _SPECIAL_WORDS:
        return text
    if _SIMPLE_INT.fullmatch(text):
        return int(text)
    if _SIMPLE_FLOAT.fullmatch(text):
        return float(text)
    return None


def load_yaml(text: str, where: str | None = None) -> Any:
    """Return the value of a single YAML document by ROS 1's rules.

    Args:
        text: the document; the value of an empty one is None.
        where: file name for error messages.

    Returns:
        None, bool, int, float, str, bytes (``!!binary``), date, datetime, list, dict or set.

    Raises:
        YamlError: the text is not valid YAML, has more than one document or an unknown tag, is nested too deeply,
            describes a value that contains itself, or has aliases that represent too many values. (Such values share
            memory, but would take forever to traverse.)
    """
    value = parse_simple_value(text.strip(" "))
    if value is not None:
        return value
    documents = load_all_yaml(text, where)
    if len(documents) > 1:
        raise YamlError("expected a single YAML document, but found another one", where)
    return documents[0] if documents else None


def load_all_yaml(text: str, where: str | None = None) -> list[Any]:
    """Return the values of all documents in a YAML stream, in order; documents are separated by ``---``.

    Args:
        text: the stream.
        where: file name for error messages.

    Raises:
        YamlError: as for `load_yaml`.
    """
    import yaml  # noqa: PLC0415 - slow to import, and simple values do not need it

    try:
        loader = _loader_class()(text)
        try:
            documents = []
            while loader.check_data():
                documents.append(loader.get_data())
            return documents
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise YamlError(_format_reason(error), where, None if mark is None else mark.line + 1) from error
    except yaml.YAMLError as error:
        position = getattr(error, "position", None)  # position of a character that is not allowed
        line = None if position is None else text.count("\n", 0, position) + 1
        raise YamlError(_format_reason(error), where, line) from error
    except RecursionError as error:
        raise YamlError("nested too deeply", where) from error
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        # Some malformed input makes the library itself fail instead of reporting an error.
        raise YamlError(f"malformed YAML ({error})", where) from error


def _format_reason(error: Exception) -> str:
    parts = [getattr(error, "context", None), getattr(error, "problem", None)]
    reason = ", ".join(part for part in parts if part)
    return reason or str(error).strip().split("\n")[0]


def _parse_degrees(text: str) -> float:
    # The result of math.radians would differ from stock's in the last digit.
    return float(_strip_call(text, "deg(")) * math.pi / 180.0


def _parse_radians(text: str) -> float:
    from pyros1.values.angles import evaluate_angle  # noqa: PLC0415 - rarely needed, and it loads Python's parser

    return evaluate_angle(_strip_call(text, "rad("))


def _strip_call(text: str, begin: str) -> str:
    return text[len(begin) : -1] if text.startswith(begin) and text.endswith(")") else text


@cache
def _loader_class() -> Any:
    """Return the loader class. The class is created when it is first needed, since PyYAML is slow to import."""
    import yaml  # noqa: PLC0415

    class Loader(yaml.SafeLoader):
        """PyYAML's safe loader with angles, and with limits on the cost of a text."""

        def __init__(self, stream: str) -> None:
            super().__init__(stream)
            self._size_and_depth: dict[int, tuple[int, int]] = {}  # id of a composed node -> (number of values, depth)
            self._copied_values = 0
            self._depth = 0

        def compose_node(self, parent: Any, index: Any) -> Any:
            is_alias = self.check_event(yaml.AliasEvent)
            self._depth += 1
            if self._depth > _MAX_DEPTH:
                raise yaml.MarkedYAMLError(problem="nested too deeply", problem_mark=self.get_mark())
            node = super().compose_node(parent, index)
            self._depth -= 1
            if is_alias:
                self._count_copy(node)
            else:
                self._measure(node)
            return node

        def _count_copy(self, node: Any) -> None:
            if id(node) not in self._size_and_depth:
                raise yaml.MarkedYAMLError(problem="a value cannot contain itself", problem_mark=node.start_mark)
            self._copied_values += self._size_and_depth[id(node)][0]
            if self._copied_values > _MAX_COPIED_VALUES:
                problem = f"the aliases represent more than {_MAX_COPIED_VALUES} values"
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)

        def _measure(self, node: Any) -> None:
            if node.id == "scalar":
                self._size_and_depth[id(node)] = 1 + len(node.value) // _CHARACTERS_PER_VALUE, 1
                return
            parts = node.value if node.id == "sequence" else [part for pair in node.value for part in pair]
            measures = [self._size_and_depth[id(part)] for part in parts]
            depth = 1 + max((depth for _, depth in measures), default=0)
            if depth > _MAX_DEPTH:
                raise yaml.MarkedYAMLError(problem="nested too deeply", problem_mark=node.start_mark)
            self._size_and_depth[id(node)] = 1 + sum(values for values, _ in measures), depth

        def compose_document(self) -> Any:
            self._size_and_depth.clear()  # nodes of the next document may have the same ids
            return super().compose_document()

        def construct_object(self, node: Any, deep: bool = False) -> Any:
            try:
                if node.id != "scalar" and node.tag in _SCALAR_TAGS:
                    problem = f"expected a scalar node, but found {node.id}"
                    raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
                if node.tag.endswith(":int") and len(node.value) > _MAX_INTEGER_DIGITS:
                    raise ValueError("too long")
                return super().construct_object(node, True)
            except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
                if node.id != "scalar":
                    raise
                text = node.value if len(node.value) <= _MAX_QUOTED_LENGTH else f"{node.value[:_MAX_QUOTED_LENGTH]}..."
                type_name = node.tag.rpartition(":")[2].lstrip("!")
                raise yaml.MarkedYAMLError(
                    problem=f"invalid {type_name}: {text}", problem_mark=node.start_mark
                ) from error

    def make_scalar_constructor(function: Any) -> Any:
        return lambda loader, node: function(loader.construct_scalar(node))

    for tag, function in (("!degrees", _parse_degrees), ("!radians", _parse_radians)):
        pattern, first_character = ANGLE_TAGS[tag]
        Loader.add_constructor(tag, make_scalar_constructor(function))
        Loader.add_implicit_resolver(tag, pattern, [first_character])
    return Loader
