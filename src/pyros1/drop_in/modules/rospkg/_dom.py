"""Elements of manifests of rosbuild's times, as xml.dom.minidom has them."""

from __future__ import annotations

from typing import Any


def children(element: Any, tag: str = "") -> list[Any]:
    """Return the child elements, or those of a name."""
    elements = [each for each in element.childNodes if each.nodeType == each.ELEMENT_NODE]
    return [each for each in elements if not tag or each.tagName == tag]


def only(root: Any, tag: str) -> Any:
    """Return the child of a name, which may be there once; None if it is not there.

    Raises:
        ValueError: there are several.
    """
    found = children(root, tag)
    if len(found) > 1:
        raise ValueError(f"must have a single '{tag}' element")
    return found[0] if found else None


def text(element: Any) -> str:
    """Return the text in an element, without that of its child elements."""
    return "".join(each.data for each in element.childNodes if each.nodeType == each.TEXT_NODE)
