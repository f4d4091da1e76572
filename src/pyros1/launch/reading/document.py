"""Parses the XML of a launch file into a tree with line numbers.

References to other files are refused (by defusedxml). Entities are limited to short texts, so that a small file cannot
expand to a large document. This module only checks that the file is XML with exactly one ``<launch>`` tag.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers.expat import ExpatError

# defusedxml.ElementTree is imported 10 ms faster than defusedxml.expatreader.
from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped]  # it has no stubs
from defusedxml.ElementTree import DefusedXMLParser  # type: ignore[import-untyped]  # it has no stubs

from pyros1.ground.errors import LaunchError

_MAX_DEPTH = 200
_MAX_ENTITIES = 100
_MAX_ENTITY_LENGTH = 256
"""Maximum number of characters in an entity. A reference to one has at least 3, so a document is at most 85
times as large as its file."""


@dataclass(slots=True)
class Element:
    """An XML element.

    Attributes:
        tag: name of the tag.
        attributes: the attributes, in order and before substitution.
        file: path of the file, or a name such as ``<stdin>`` if the document is not from a file.
        line: line of the opening tag, counted from 1.
        children: the child elements, in order.
        text: all character data directly in the element, joined.
    """

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""

    @property
    def place(self) -> str:
        """File and line, ``main.launch:7``."""
        return f"{self.file}:{self.line}"

    def error(self, message: str) -> LaunchError:
        """Return an error with this element's file and line."""
        return LaunchError(message, self.file, self.line)


class _TreeBuilder:
    def __init__(self, file: str) -> None:
        self._file = file
        self._stack: list[Element] = []
        self._text_parts: list[list[str]] = []
        self.root: Element | None = None
        self._num_entities = 0
        self.parser = DefusedXMLParser(forbid_dtd=False, forbid_entities=False, forbid_external=True)
        expat = self.parser.parser
        # This parser's own handlers build an element tree without line numbers; only its security checks are used.
        expat.DefaultHandlerExpand = None
        expat.CommentHandler = None
        expat.ProcessingInstructionHandler = None
        expat.buffer_text = True
        expat.ordered_attributes = True
        expat.namespace_prefixes = True
        expat.StartElementHandler = self._on_start
        expat.EndElementHandler = self._on_end
        expat.CharacterDataHandler = self._on_text
        expat.EntityDeclHandler = self._on_entity
        expat.UnparsedEntityDeclHandler = self._on_unparsed_entity
        self._expat = expat

    def _on_start(self, tag: str, attributes: list[str]) -> None:
        pairs = {_as_written(name): value for name, value in zip(attributes[::2], attributes[1::2], strict=True)}
        element = Element(_as_written(tag), pairs, self._file, self._expat.CurrentLineNumber)
        if len(self._stack) >= _MAX_DEPTH:
            raise element.error("Invalid roslaunch XML syntax: tags are nested too deeply")
        if self._stack:
            self._stack[-1].children.append(element)
        else:
            self.root = element
        self._stack.append(element)
        self._text_parts.append([])

    def _on_end(self, _tag: str) -> None:
        self._stack.pop().text = "".join(self._text_parts.pop())

    def _on_entity(self, name: str, is_parameter: bool, value: str | None, *_ids: str | None) -> None:
        self._num_entities += 1
        if is_parameter or value is None:
            reason = "only entities of plain text are allowed"
        elif "&" in value or "<" in value or len(value) > _MAX_ENTITY_LENGTH:
            reason = f"only plain text of at most {_MAX_ENTITY_LENGTH} characters is allowed"
        elif self._num_entities > _MAX_ENTITIES:
            reason = f"the file has more than {_MAX_ENTITIES} entities"
        else:
            return
        self._refuse(f"the entity {name!r} is not allowed: {reason}")

    def _on_unparsed_entity(self, name: str, *_ids: str | None) -> None:
        self._refuse(f"the entity {name!r} is not allowed: only entities of plain text are allowed")

    def _refuse(self, reason: str) -> None:
        raise LaunchError(f"Invalid roslaunch XML syntax: {reason}", self._file, self._expat.CurrentLineNumber)

    def _on_text(self, data: str) -> None:
        if self._text_parts:
            self._text_parts[-1].append(data)


def _as_written(name: str) -> str:
    """Return a tag's or attribute's name as it is in the file; expat returns "uri}name" or "uri}name}prefix"."""
    return ":".join(reversed(name.split("}")[1:])) if "}" in name else name


def parse_document(data: str | bytes, file: str) -> Element:
    """Parse a launch file.

    Args:
        data: content of the file.
        file: path of the file, for error messages.

    Returns:
        The ``<launch>`` element, which need not be the root (X07).

    Raises:
        LaunchError: the file is not well-formed XML, or does not have exactly one ``<launch>``.
    """
    builder = _TreeBuilder(file)
    try:
        builder.parser.parser.Parse(data, True)
    except ExpatError as error:
        raise LaunchError(f"Invalid roslaunch XML syntax: {error}", file, error.lineno) from error
    except DefusedXmlException as error:
        line = builder.parser.parser.CurrentLineNumber
        raise LaunchError(
            "Invalid roslaunch XML syntax: references to other files are not allowed", file, line
        ) from error
    except (ValueError, LookupError) as error:  # an unknown encoding, NUL characters
        raise LaunchError(f"Invalid roslaunch XML syntax: {error}", file) from error
    launch_tags = [] if builder.root is None else [tag for tag in _iter_tree(builder.root) if tag.tag == "launch"]
    if not launch_tags:
        line = None if builder.root is None else builder.root.line
        raise LaunchError("Invalid roslaunch XML syntax: no root <launch> tag", file, line)
    if len(launch_tags) > 1:
        raise launch_tags[1].error("Invalid roslaunch XML syntax: there can be only one <launch> tag")
    return launch_tags[0]


def _iter_tree(element: Element) -> Iterator[Element]:
    yield element
    for child in element.children:
        yield from _iter_tree(child)
