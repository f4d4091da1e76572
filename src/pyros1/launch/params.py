"""``<param>`` and ``<rosparam>`` (https://wiki.ros.org/roslaunch/XML/param, https://wiki.ros.org/roslaunch/XML/rosparam)."""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable, Iterator
from typing import Any

from pyros1.errors import LaunchError
from pyros1.launch.convert import convert_bool, convert_value
from pyros1.launch.document import Element
from pyros1.launch.plan import ParamFileAction, Plan
from pyros1.launch.scope import Scope, ScopeSubstituter
from pyros1.launch.substitution import substitute
from pyros1.names import is_global, is_private

Attribute = Callable[[Element, Scope, str], "str | None"]
_SOURCES = ("value", "textfile", "binfile", "command")


class ParamReader:
    """Adds parameters to a plan.

    Args:
        plan: the plan.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan

    def param(self, element: Element, scope: Scope, attribute: Attribute, node: str | None = None) -> None:
        """Handle a ``<param>``.

        Args:
            element: the tag.
            scope: where it stands.
            attribute: reads attributes.
            node: full name of the node it stands in, None outside of one.
        """
        name = attribute(element, scope, "name")
        if not name or not name.strip():
            raise LaunchError("<param> tag is missing required attribute: 'name'")
        name = name.strip()
        try:
            value = self._value(element, scope, attribute, name)
        except LaunchError as error:
            if error.line is not None or str(error).startswith("<param>"):
                raise
            raise LaunchError(f"Invalid <param> tag: {error}") from error
        self.set(name, value, scope, node)

    def set(self, name: str, value: Any, scope: Scope, node: str | None) -> None:
        """Add a parameter that is called `name` in `scope`, or inside `node`."""
        if node is not None:  # everything inside a node tag is private to the node
            self.add(f"{node}/{name.lstrip('~/')}", value)
        elif is_private(name):
            scope.private_params.append((name[1:], value))
        else:
            self.add(scope.resolve_param(name), value)

    def _value(self, element: Element, scope: Scope, attribute: Attribute, name: str) -> Any:
        given = [source for source in _SOURCES if source in element.attributes]
        if len(given) != 1:
            raise LaunchError("<param> tag must have one and only one of value/textfile/binfile.")
        text = attribute(element, scope, given[0]) or ""
        kind = attribute(element, scope, "type") or "auto"
        if given[0] == "value":
            return convert_value(text.strip(), kind)
        if given[0] == "textfile":
            return scope.resources.read_text(text)
        if given[0] == "binfile":
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
            return convert_value(scope.resources.run_command(words), kind)
        except LaunchError as error:
            raise LaunchError(f"Cannot load command parameter [{name}]: {error}") from error

    def rosparam(self, element: Element, scope: Scope, attribute: Attribute, node: str | None = None) -> None:
        """Handle a ``<rosparam>``; the arguments are those of `param`."""
        command = attribute(element, scope, "command") or "load"
        file = attribute(element, scope, "file")
        name = (attribute(element, scope, "param") or "").strip()
        namespace = (attribute(element, scope, "ns") or "").strip()
        full = _join(namespace, name)
        if command == "load":
            self._load(element, scope, attribute, file, full, node)
        elif command in ("dump", "delete"):
            if command == "delete" and file is not None:
                raise LaunchError("error loading <rosparam> tag: file attribute is not allowed for delete")
            if command == "dump" and not file:
                raise LaunchError("error loading <rosparam> tag: file attribute is required for dump")
            if command == "delete" and not full:
                raise LaunchError("error loading <rosparam> tag: delete needs a param or ns")
            target = f"{node}/{full.lstrip('~/')}" if node else scope.resolve_param(full.lstrip("~"))
            self._plan.actions.append(ParamFileAction("dump" if command == "dump" else "delete", target, file or ""))
        else:
            raise LaunchError("error loading <rosparam> tag: command must be 'load', 'dump', or 'delete'")

    def _load(
        self, element: Element, scope: Scope, attribute: Attribute, file: str | None, name: str, node: str | None
    ) -> None:
        from pyros1.values import YamlError, load_all_yaml  # noqa: PLC0415 - many files need no YAML

        where, first_line = element.file, element.line
        text = element.text
        if file is not None:
            where, first_line = file, 1
            if not os.path.isabs(file) and not file.strip():
                raise LaunchError("error loading <rosparam> tag: file attribute is empty")
            try:
                text = scope.resources.read_bytes(file).decode("utf-8")
            except FileNotFoundError as error:
                raise LaunchError(f"error loading <rosparam> tag: file does not exist [{file}]") from error
            except (OSError, UnicodeDecodeError) as error:
                raise LaunchError(f"error loading <rosparam> tag: cannot read [{file}]: {error}") from error
        subst = attribute(element, scope, "subst_value")
        if subst is not None and convert_bool(subst, "subst_value"):
            text = substitute(text, ScopeSubstituter(scope))
        if not text.strip():
            return
        try:
            documents = load_all_yaml(_dedent(text))
        except YamlError as error:
            line = first_line if error.line is None else first_line + error.line - 1
            raise LaunchError(f"error loading <rosparam> tag: {_without_place(error)}", where, line) from error
        for value in documents:
            if not isinstance(value, dict) and not name:
                raise LaunchError(
                    "error loading <rosparam> tag: 'param' attribute must be set for non-dictionary values"
                )
            for key, leaf in _leaves(name, value):
                self.set(key, leaf, scope, node)

    def add(self, name: str, value: Any) -> None:
        """Add a parameter under its full name, warning when it hides another one (X76)."""
        params = self._plan.params
        parent = name.rpartition("/")[0]
        while parent:
            if parent in params:
                self._plan.warnings.append(f"parameter [{name}] conflicts with parent parameter [{parent}]")
            parent = parent.rpartition("/")[0]
        params[name] = value


def _join(namespace: str, name: str) -> str:
    if not namespace or is_global(name) or is_private(name):
        return name or namespace
    return f"{namespace.rstrip('/')}/{name}" if name else namespace


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the leaf parameters of a loaded value: dicts become namespaces (X66)."""
    if not isinstance(value, dict):
        yield name, value
        return
    for key, item in value.items():
        if not isinstance(key, str):
            raise LaunchError(f"error loading <rosparam> tag: parameter names must be strings, not {key!r}")
        yield from _leaves(f"{name.rstrip('/')}/{key}" if name else key, item)


def _without_place(error: Exception) -> str:
    text = str(error)
    return text.partition(": ")[2] if text.startswith("<yaml>:") else text


def _dedent(text: str) -> str:
    """Turn leading tabs, which YAML refuses and XML editors like, into spaces only where a whole line is blank."""
    return "\n".join("" if line.isspace() else line for line in text.split("\n"))
