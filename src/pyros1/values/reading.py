"""YAML text to values, by ROS 1's rules.

ROS 1 reads parameters as YAML 1.1 (``yes`` and ``on`` are booleans, ``010`` is eight, ``1:30`` is ninety, ``1e3`` is a
string because a YAML 1.1 float needs a dot) plus four spellings of angles: ``deg(90)``, ``rad(pi/2)``, ``!degrees 90``
and ``!radians pi/2`` (https://wiki.ros.org/rosparam#YAML_Format). The scanner is ruamel.yaml's; which plain words mean
what is decided in `pyros1.values.scalars`. Nothing in a text can name a Python object: the only values made are None,
bool, int, float, str, bytes, date, datetime, list, dict and set.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, NamedTuple

from pyros1.errors import Error
from pyros1.values.scalars import BOOLEANS, SCALARS, scalar_tag

if TYPE_CHECKING:
    from collections.abc import Iterator

_TAG = "tag:yaml.org,2002:"
_DEEPEST = 200  # levels of nesting
_MOST_COPIES = 50_000  # values that aliases and merge keys stand for, all together; long texts count more than once
_TEXT_UNIT = 100  # characters of a text that count as one value
_SHOWN = 60  # characters of a wrong value in an error

# The texts that need no YAML machinery: most parameters given on a command line are one of these.
_SIMPLE_WORD = re.compile(r"[A-Za-z_/][\w/.-]*", re.ASCII)
_SIMPLE_INT = re.compile(r"-?(?:0|[1-9][0-9]{0,17})")
_SIMPLE_FLOAT = re.compile(r"-?[0-9]+\.[0-9]+")
_SPECIAL_WORDS = frozenset((*BOOLEANS, "null"))


class YamlError(Error, ValueError):
    """A text is not usable YAML.

    Args:
        message: what is wrong.
        where: file name or other origin, None if unknown.
        line: 1-based line number, None if unknown.
    """

    def __init__(self, message: str, where: str | None = None, line: int | None = None) -> None:
        self.where = where
        self.line = line
        place = f"{where or '<yaml>'}:{line}: " if line is not None else f"{where}: " if where else ""
        super().__init__(place + message)


def load_yaml(text: str, where: str | None = None) -> Any:
    """Read one YAML document by ROS 1's rules.

    Args:
        text: the document; empty text is None.
        where: file name for error messages.

    Returns:
        None, bool, int, float, str, bytes (``!!binary``), date, datetime, list, dict or set.

    Raises:
        YamlError: the text is not valid YAML, holds more than one document, an unknown tag, or contains itself; it is
            nested too deeply; or its aliases stand for too much: they share their values here, but who looks at all of
            them would never end.
    """
    word = text.strip(" ")
    if _SIMPLE_WORD.fullmatch(word) and word.lower() not in _SPECIAL_WORDS:
        return word
    if _SIMPLE_INT.fullmatch(word):
        return int(word)
    if _SIMPLE_FLOAT.fullmatch(word):
        return float(word)
    documents = _load(text, where)
    if len(documents) > 1:
        raise YamlError("expected a single YAML document, but found another one", where)
    return documents[0] if documents else None


def load_all_yaml(text: str, where: str | None = None) -> list[Any]:
    """Read every document of a YAML stream (``---`` between them).

    Args:
        text: the stream.
        where: file name for error messages.

    Returns:
        The documents in order; see `load_yaml` for the kinds of values.

    Raises:
        YamlError: as `load_yaml`.
    """
    return _load(text, where)


# Reading -------------------------------------------------------------------------------------------------------------


def _load(text: str, where: str | None) -> list[Any]:
    from ruamel.yaml import YAML  # noqa: PLC0415 - slow to import, and simple values need none of it
    from ruamel.yaml.docinfo import DocInfo  # noqa: PLC0415 - with the one above
    from ruamel.yaml.error import MarkedYAMLError, YAMLError  # noqa: PLC0415 - with the one above

    yaml = YAML(typ="safe", pure=True)
    yaml.Resolver = _resolver_class()
    yaml.Scanner = _scanner_class()
    yaml.doc_infos.append(DocInfo())  # where the parser notes a %YAML directive
    documents: list[Any] = []
    builder = _Builder(where)
    try:
        constructor, parser = yaml.get_constructor_parser(text)
        try:
            composer = constructor.composer
            while composer.check_node():
                documents.append(builder.document(composer.get_node()))
        finally:
            parser.dispose()
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise YamlError(_reason(error), where, None if mark is None else mark.line + 1) from error
    except YAMLError as error:
        raise YamlError(_reason(error), where) from error
    except RecursionError as error:
        raise YamlError("nested too deeply", where) from error
    except (IndexError, AttributeError, AssertionError, TypeError, ValueError) as error:
        if isinstance(error, YamlError):
            raise
        # Some malformed texts trip the scanner itself instead of being reported by it.
        raise YamlError(f"malformed YAML ({error})", where) from error
    return documents


def _reason(error: Exception) -> str:
    parts = [getattr(error, "context", None), getattr(error, "problem", None)]
    reason = ", ".join(part for part in parts if part)
    return reason or str(error).strip().split("\n")[0]


def _resolver_class() -> Any:
    """ruamel's resolver with ROS 1's reading of plain words (made on demand: ruamel.yaml is slow to import)."""
    from ruamel.yaml.nodes import MappingNode, ScalarNode, SequenceNode  # noqa: PLC0415 - slow to import
    from ruamel.yaml.resolver import BaseResolver  # noqa: PLC0415 - slow to import
    from ruamel.yaml.tag import Tag  # noqa: PLC0415 - slow to import

    class Resolver(BaseResolver):
        def __init__(self, version: Any = None, loader: Any = None, loadumper: Any = None) -> None:
            super().__init__(loadumper if loadumper is not None else loader)

        @property
        def processing_version(self) -> tuple[int, int]:
            return (1, 1)

        def resolve(self, kind: Any, value: Any, implicit: Any) -> Any:
            if kind is ScalarNode:
                if not implicit[0]:
                    return Tag(suffix=_TAG + "str")
                tag = scalar_tag(value)
                return Tag(suffix="!" + tag if tag in ("degrees", "radians") else _TAG + tag)
            return Tag(suffix=_TAG + {SequenceNode: "seq", MappingNode: "map"}[kind])

    return Resolver


def _scanner_class() -> Any:
    """ruamel's scanner with a bound on nesting: the time it takes grows with the square of the depth, or worse."""
    from ruamel.yaml.scanner import Scanner, ScannerError  # noqa: PLC0415 - slow to import

    class BoundedScanner(Scanner):
        def fetch_flow_collection_start(self, *arguments: Any, **named: Any) -> None:
            self._check(len(self.flow_context))
            super().fetch_flow_collection_start(*arguments, **named)

        def add_indent(self, column: int) -> bool:
            self._check(len(self.indents))
            return bool(super().add_indent(column))

        def _check(self, depth: int) -> None:
            if depth >= _DEEPEST:
                raise ScannerError(problem="nested too deeply", problem_mark=self.reader.get_mark())

    return BoundedScanner


_COLLECTIONS = {"seq": "sequence", "omap": "sequence", "pairs": "sequence", "map": "mapping", "set": "mapping"}


class _Built(NamedTuple):
    """A value that was made, how many values it is made of, aliases counted out, and how many levels it has."""

    value: Any
    weight: int
    depth: int


_UNKNOWN = _Built(None, 1, 1)


class _Builder:
    """Makes Python values from the nodes of a text's documents."""

    def __init__(self, where: str | None) -> None:
        self._where = where
        self._done: dict[int, _Built] = {}
        self._open: set[int] = set()
        self._copies = 0

    def document(self, node: Any) -> Any:
        """Return the value of a document, given its root."""
        self._done.clear()  # another document's nodes may be at the same places in memory
        return self.build(node)

    def build(self, node: Any) -> Any:
        """Return a node's value."""
        key = id(node)
        built = self._done.get(key)
        if built is not None:  # an alias: the same value again
            self._copies += built.weight
            if self._copies > _MOST_COPIES:
                raise self._error(f"its aliases stand for more than {_MOST_COPIES} values", node)
            return built.value
        if key in self._open:
            raise self._error("a value cannot contain itself", node)
        self._open.add(key)
        value = self._construct(node)
        self._open.discard(key)
        self._done[key] = self._measured(node, value)
        return value

    def _measured(self, node: Any, value: Any) -> _Built:
        if node.id == "scalar":
            return _Built(value, 1 + len(node.value) // _TEXT_UNIT, 1)
        parts = node.value if node.id == "sequence" else [part for pair in node.value for part in pair]
        inside = [self._done.get(id(part), _UNKNOWN) for part in parts]
        depth = 1 + max((part.depth for part in inside), default=0)
        if depth > _DEEPEST:
            raise self._error("nested too deeply", node)
        return _Built(value, 1 + sum(part.weight for part in inside), depth)

    def _error(self, message: str, node: Any) -> YamlError:
        return YamlError(message, self._where, node.start_mark.line + 1)

    def _construct(self, node: Any) -> Any:
        tag = str(node.tag)
        name = tag.removeprefix(_TAG) if tag.startswith(_TAG) else tag
        kind = node.id
        if name in SCALARS:
            if kind != "scalar":
                raise self._error(f"expected a scalar node, but found {kind}", node)
            try:
                return SCALARS[name](node.value)
            except (ValueError, KeyError, OverflowError, ZeroDivisionError) as error:
                text = node.value if len(node.value) <= _SHOWN else f"{node.value[:_SHOWN]}..."
                raise self._error(f"invalid {name.lstrip('!')}: {text}", node) from error
        wanted = _COLLECTIONS.get(name)
        if wanted is None:
            raise self._error(f"could not determine a constructor for the tag {tag!r}", node)
        if kind != wanted:
            raise self._error(f"expected a {wanted} node, but found {kind}", node)
        if name == "seq":
            return [self.build(item) for item in node.value]
        if name == "map":
            return dict(self._pairs(node))
        if name == "set":
            return {key for key, _ in self._pairs(node)}
        pairs: list[Any] = []
        for item in node.value:
            if item.id != "mapping" or len(item.value) != 1:
                raise self._error("expected a mapping of length 1", item)
            pairs.extend(self._pairs(item))
        return pairs

    def _pairs(self, node: Any) -> Iterator[tuple[Any, Any]]:
        own: list[tuple[Any, Any]] = []
        merged: list[tuple[Any, Any]] = []
        for key_node, value_node in node.value:
            if str(key_node.tag) == _TAG + "merge":
                merged.extend(self._merge(value_node))
                continue
            key = self.build(key_node)
            try:
                hash(key)
            except TypeError as error:
                raise self._error("found unhashable key", key_node) from error
            own.append((key, self.build(value_node)))
        yield from merged
        yield from own

    def _merge(self, node: Any) -> list[tuple[Any, Any]]:
        if node.id == "mapping":
            value = self.build(node)
            if isinstance(value, dict):
                return list(value.items())
        elif node.id == "sequence":
            pairs: list[tuple[Any, Any]] = []
            for item in reversed(node.value):  # the first one named wins
                if item.id != "mapping":
                    raise self._error("expected a mapping for merging", item)
                pairs.extend(self._merge(item))
            return pairs
        raise self._error("expected a mapping or list of mappings for merging", node)
