"""Reads ``<param>`` and ``<rosparam>`` tags
(https://wiki.ros.org/roslaunch/XML/param, https://wiki.ros.org/roslaunch/XML/rosparam).
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from typing import Any, Literal

from pyros1.ground.errors import LaunchError
from pyros1.ground.names import canonicalize_name, is_private, ns_join
from pyros1.launch.plan import ParamFileAction, Plan
from pyros1.launch.reading.convert import convert_bool, convert_value
from pyros1.launch.reading.document import Element
from pyros1.launch.reading.scope import Scope, ScopeSubstituter
from pyros1.launch.reading.substitution import substitute

Attribute = Callable[[Element, Scope, str], "str | None"]
_SOURCES = ("value", "textfile", "binfile", "command")


class ParamReader:
    """Adds parameters to a plan.

    Args:
        plan: the plan to add parameters to.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan

    def read_param(self, element: Element, scope: Scope, attribute: Attribute, *, private: bool = False) -> None:
        """Handle a ``<param>``.

        Args:
            element: the ``<param>`` element.
            scope: the element's scope.
            attribute: returns the value of an element's attribute.
            private: whether the element is in a ``<node>``, where all names are private.
        """
        name = attribute(element, scope, "name")
        if name is None:
            raise LaunchError("<param> tag is missing required attribute: 'name'")
        name = name.strip()
        # In any other namespace, an empty name sets the parameter with the namespace's name.
        if not name and not private and scope.namespace == "/":
            raise LaunchError("<param> tag has an empty 'name': a single value cannot replace all parameters")
        try:
            value = self._value(element, scope, attribute, name)
        except LaunchError as error:
            if error.line is not None or str(error).startswith("<param>"):
                raise
            raise LaunchError(f"Invalid <param> tag: {error}") from error
        if private or is_private(name):  # a private parameter is set for all later nodes in the scope
            scope.private_params.append((name.removeprefix("~"), value))
        else:
            self.add(ns_join(scope.namespace, name), value)

    def _value(self, element: Element, scope: Scope, attribute: Attribute, name: str) -> Any:
        present_sources = [source for source in _SOURCES if source in element.attributes]
        if len(present_sources) != 1:
            raise LaunchError("<param> tag must have one and only one of value/textfile/binfile.")
        text = attribute(element, scope, present_sources[0]) or ""
        type_name = (element.attributes.get("type") or "auto").lower().strip()  # without substitution
        if present_sources[0] == "value":
            return convert_value(text.strip(), type_name)
        if present_sources[0] == "textfile":
            return convert_value(scope.resources.read_text(text), type_name)
        if present_sources[0] == "binfile":
            try:
                return scope.resources.read_bytes(text)
            except OSError as error:
                raise LaunchError(f"cannot read [{text}]: {error.strerror}") from error
        if not text.strip():
            raise LaunchError(f"Cannot load command parameter [{name}]: the command is empty")
        try:
            words = shlex.split(text)
        except ValueError as error:
            raise LaunchError(f"Cannot load command parameter [{name}]: {error} in [{text}]") from error
        try:
            return convert_value(scope.resources.run_command(words), type_name)
        except LaunchError as error:
            raise LaunchError(f"Cannot load command parameter [{name}]: {error}") from error

    def read_rosparam(self, element: Element, scope: Scope, attribute: Attribute) -> None:
        """Handle a ``<rosparam>``; arguments as for `read_param`."""
        command = attribute(element, scope, "command") or "load"
        file = attribute(element, scope, "file")
        inner_name = ns_join(attribute(element, scope, "ns") or "", attribute(element, scope, "param") or "")
        name = ns_join(scope.namespace, inner_name) if inner_name else scope.namespace
        subst_value = attribute(element, scope, "subst_value")
        substituter = (
            ScopeSubstituter(scope) if subst_value is not None and convert_bool(subst_value, "subst_value") else None
        )
        if command == "load":
            self._load(element, scope, substituter, file, name, needs_dict=not inner_name)
        elif command in ("dump", "delete"):
            if command == "delete" and file is not None:
                raise LaunchError("error loading <rosparam> tag: file attribute is not allowed for delete")
            if command == "dump" and not file:
                raise LaunchError("error loading <rosparam> tag: file attribute is required for dump")
            action: Literal["dump", "delete"] = "dump" if command == "dump" else "delete"
            self._plan.actions.append(ParamFileAction(action, canonicalize_name(name), file or ""))
        else:
            raise LaunchError("error loading <rosparam> tag: command must be 'load', 'dump', or 'delete'")

    def _load(
        self,
        element: Element,
        scope: Scope,
        substituter: ScopeSubstituter | None,
        file: str | None,
        name: str,
        *,
        needs_dict: bool,
    ) -> None:
        from pyros1.values import YamlError, load_yaml  # noqa: PLC0415 - many files need no YAML

        file_name, first_line = element.file, element.line
        text = element.text
        if file is not None:
            file_name, first_line = file, 1
            try:
                text = scope.resources.read_file(file)
            except LaunchError as error:
                raise LaunchError(f"error loading <rosparam> tag: {error}") from error
        if substituter is not None:
            text = substitute(text, substituter)
        try:
            value = load_yaml(_clear_blank_lines(text)) if text.strip() else None
        except YamlError as error:
            line = first_line if error.line is None else first_line + error.line - 1
            raise LaunchError(f"error loading <rosparam> tag: {_without_location(error)}", file_name, line) from error
        if value is None:  # empty YAML and null set nothing
            return
        if needs_dict and not isinstance(value, dict):
            raise LaunchError("error loading <rosparam> tag: 'param' attribute must be set for non-dictionary values")
        if name == "/" and not isinstance(value, dict):
            raise LaunchError("error loading <rosparam> tag: only a dictionary can be loaded into the namespace '/'")
        for key, leaf in _leaves(name, value):
            self.add(key, leaf)

    def add(self, name: str, value: Any) -> None:
        """Add a parameter by its full name, and warn if it conflicts with another parameter (X76)."""
        name = canonicalize_name(name)
        params = self._plan.params
        parent = name.rpartition("/")[0]
        while parent:
            if parent in params:
                self._plan.warnings.append(f"parameter [{name}] conflicts with parent parameter [{parent}]")
            parent = parent.rpartition("/")[0]
        params[name] = value


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the parameters in a loaded value, where dictionaries become namespaces (X66)."""
    if not isinstance(value, dict):
        yield name, value
        return
    for key, item in value.items():
        if not isinstance(key, str):
            raise LaunchError(f"error loading <rosparam> tag: parameter names must be strings, not {key!r}")
        yield from _leaves(ns_join(name, key), item)


def _without_location(error: Exception) -> str:
    text = str(error)
    return text.partition(": ")[2] if text.startswith("<yaml>:") else text


def _clear_blank_lines(text: str) -> str:
    """Remove blanks and tabs from blank lines: XML editors write tabs, but YAML does not allow them."""
    return "\n".join("" if line.isspace() else line for line in text.split("\n"))
