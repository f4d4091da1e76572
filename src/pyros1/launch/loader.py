"""Launch files to a `Plan`: every tag in order, top to bottom (https://wiki.ros.org/roslaunch/XML).

One method per tag. Each gets the element and the scope it stands in, and writes what it means to the plan.
"""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable, Sequence

from pyros1.errors import Error, LaunchError
from pyros1.launch.convert import convert_bool, convert_condition
from pyros1.launch.document import Element, parse_document
from pyros1.launch.nodes import NodeReader
from pyros1.launch.params import ParamReader
from pyros1.launch.plan import ArgPlan, MachinePlan, Plan
from pyros1.launch.resources import Resources
from pyros1.launch.scope import Scope, ScopeSubstituter
from pyros1.launch.substitution import substitute

STDIN = "-"
_MAX_INCLUDES = 100
_NODE_ATTRIBUTES = (
    "pkg",
    "type",
    "name",
    "args",
    "machine",
    "respawn",
    "respawn_delay",
    "required",
    "ns",
    "clear_params",
)
_TEST_ATTRIBUTES = ("pkg", "type", "name", "test-name", "args", "machine", "ns", "clear_params", "cwd", "launch-prefix")
ATTRIBUTES: dict[str, tuple[str, ...]] = {
    "launch": ("deprecated",),
    "arg": ("name", "value", "default", "doc"),
    "include": ("file", "ns", "clear_params", "pass_all_args"),
    "group": ("ns", "clear_params"),
    "node": (*_NODE_ATTRIBUTES, "output", "cwd", "launch-prefix"),
    "test": (*_TEST_ATTRIBUTES, "time-limit", "retry"),
    "param": ("name", "value", "textfile", "binfile", "command", "type"),
    "rosparam": ("command", "file", "param", "ns", "subst_value"),
    "remap": ("from", "to"),
    "env": ("name", "value"),
    "machine": ("name", "address", "env-loader", "ssh-port", "user", "password", "default", "timeout"),
}
"""The attributes of each tag, besides if and unless."""


def load_plan(files: Sequence[str], arguments: dict[str, str], resources: Resources) -> Plan:
    """Read launch files into one plan (X02, X03).

    Args:
        files: paths; ``-`` is standard input.
        arguments: ``name:=value`` of the command line; names that no file declares are ignored.
        resources: where files, packages and the environment come from.

    Returns:
        The plan.

    Raises:
        LaunchError: a file cannot be used; the text names file and line.
    """
    loader = _Loader(resources)
    for file in files:
        loader.top_level(file, arguments)
    return loader.plan


class _Loader:
    def __init__(self, resources: Resources) -> None:
        self.plan = Plan()
        self._resources = resources
        self._depth = 0
        self._params = ParamReader(self.plan)
        self._nodes = NodeReader(self.plan, self._params, self.attribute, self.children)
        self._tags: dict[str, Callable[[Element, Scope], None]] = {
            "arg": self._arg,
            "include": self._include,
            "group": self._group,
            "node": self._nodes.node,
            "test": self._nodes.test,
            "param": self._param,
            "rosparam": self._rosparam,
            "remap": self._remap,
            "env": self._env,
            "machine": self._machine,
        }

    def top_level(self, file: str, arguments: dict[str, str]) -> None:
        """Read a file named by the user."""
        data: str | bytes = self._resources.stdin() if file == STDIN else self._read(file)
        name = "<stdin>" if file == STDIN else file
        root = parse_document(data, name)
        self.plan.files.append(name)
        self._launch(root, Scope(self._resources, name, given=dict(arguments)))

    def _read(self, file: str) -> bytes:
        try:
            return self._resources.read_bytes(file)
        except OSError as error:
            raise LaunchError(f"cannot read [{file}]: {error.strerror}") from error

    def _launch(self, root: Element, scope: Scope) -> None:
        self._check_attributes(root, scope)
        if "deprecated" in root.attributes:
            text = self.attribute(root, scope, "deprecated")
            self.plan.warnings.append(f"[{scope.file}] DEPRECATED: {text}")
        self.children(root, scope, self._tags)

    # What all tags share -------------------------------------------------------------------------------------------

    def children(self, parent: Element, scope: Scope, tags: dict[str, Callable[[Element, Scope], None]]) -> None:
        """Handle the tags inside `parent`; those not in `tags` only warn (X56)."""
        for element in parent.children:
            handler = tags.get(element.tag)
            if handler is None:
                self._unknown_tag(element, parent, tags)
                continue
            try:
                if self._applies(element, scope):
                    self._check_attributes(element, scope)
                    handler(element, scope)
            except LaunchError as error:
                if error.line is not None:
                    raise
                raise element.error(str(error)) from error
            except Error as error:
                raise element.error(str(error)) from error

    def _unknown_tag(
        self, element: Element, parent: Element, tags: dict[str, Callable[[Element, Scope], None]]
    ) -> None:
        if element.tag == "master" and parent.tag == "launch":
            self.plan.warnings.append("ignoring defunct <master /> tag")
            return
        text = f"unrecognized tag {element.tag}"
        if parent.tag != "launch":
            text = f"[{element.file}] unrecognized '{element.tag}' child tag in the parent tag element: <{parent.tag}>"
        self.plan.warnings.append(text + _did_you_mean(element.tag, tags))

    def _applies(self, element: Element, scope: Scope) -> bool:
        if "if" in element.attributes and "unless" in element.attributes:
            raise LaunchError("cannot set both 'if' and 'unless' on the same tag")
        if "if" in element.attributes:
            return convert_condition(self.attribute(element, scope, "if") or "")
        if "unless" in element.attributes:
            return not convert_condition(self.attribute(element, scope, "unless") or "")
        return True

    def _check_attributes(self, element: Element, scope: Scope) -> None:
        known = ATTRIBUTES[element.tag]
        for name in element.attributes:
            if name not in known and name not in ("if", "unless"):
                self.plan.warnings.append(
                    f"[{scope.file}] unknown <{element.tag}> attribute '{name}'" + _did_you_mean(name, known)
                )

    def attribute(self, element: Element, scope: Scope, name: str) -> str | None:
        """Return an attribute, substitutions done; None if the tag does not have it."""
        raw = element.attributes.get(name)
        return None if raw is None else substitute(raw, ScopeSubstituter(scope))

    def _flag(self, element: Element, scope: Scope, name: str) -> bool:
        text = self.attribute(element, scope, name)
        return text is not None and convert_bool(text, name)

    # Tags ----------------------------------------------------------------------------------------------------------

    def _arg(self, element: Element, scope: Scope) -> None:
        name = self.attribute(element, scope, "name")
        if not name:
            raise LaunchError("Invalid <arg> tag: it needs a 'name'")
        if "value" in element.attributes and "default" in element.attributes:
            raise LaunchError("Invalid <arg> tag: it must have one and only one of value/default")
        value = self.attribute(element, scope, "value")
        try:
            scope.declare(name, value, lambda: self.attribute(element, scope, "default"))
        except LaunchError as error:
            if error.line is not None:
                raise
            raise element.error(f"Invalid <arg> tag: {error}") from error
        if value is None and not scope.included:
            self._document(element, scope, name)

    def _document(self, element: Element, scope: Scope, name: str) -> None:
        """Note an argument of a top-level file for ``--ros-args``."""
        try:
            default = self.attribute(element, scope, "default")
        except LaunchError:  # it was given, so its default need not be good for anything
            default = element.attributes["default"]
        self.plan.args[name] = ArgPlan(name, default, element.attributes.get("doc"))

    def _group(self, element: Element, scope: Scope) -> None:
        inner = scope.child(self._namespace(element, scope))
        self._clear(element, scope, inner)
        self.children(element, inner, self._tags)
        scope.default_machine = inner.default_machine

    def _namespace(self, element: Element, scope: Scope) -> str | None:
        namespace = self.attribute(element, scope, "ns")
        if namespace is not None and not namespace.strip():
            raise LaunchError(f"<{element.tag}> tag has an empty 'ns' attribute")
        return namespace

    def _clear(self, element: Element, scope: Scope, inner: Scope) -> None:
        if self._flag(element, scope, "clear_params"):
            if "ns" not in element.attributes:
                raise LaunchError("'ns' attribute must be set in order to use 'clear_params'")
            self.plan.clear_params.append(inner.namespace)

    def _include(self, element: Element, scope: Scope) -> None:
        file = self.attribute(element, scope, "file")
        if not file:
            raise LaunchError("<include> tag is missing required attribute: 'file'")
        pass_all = self._flag(element, scope, "pass_all_args")
        inner = scope.child(self._namespace(element, scope))
        self._clear(element, scope, inner)
        # <arg> tags in here may only name values; they are checked against what the file declares once it is read.
        inner.given = dict(scope.args) if pass_all else {}
        inner.declared = set()
        self.children(element, inner, {"arg": self._given_arg, "env": self._env})
        given = inner.given
        if self._depth >= _MAX_INCLUDES:
            raise LaunchError(f"includes are nested more than {_MAX_INCLUDES} deep: does [{file}] include itself?")
        content = self._read(file)
        included = inner.child(file=file, included=True, args={}, declared=set(), given=given, pass_all=pass_all)
        root = parse_document(content, file)
        self.plan.files.append(file)
        self._depth += 1
        self._launch(root, included)
        self._depth -= 1
        if not pass_all:
            unused = sorted(set(given) - included.declared)
            if unused:
                raise LaunchError(f"unused args [{', '.join(unused)}] for include of [{file}]")

    def _given_arg(self, element: Element, inner: Scope) -> None:
        name = self.attribute(element, inner, "name")
        if not name:
            raise LaunchError("Invalid <arg> tag: it needs a 'name'")
        value = self.attribute(element, inner, "value")
        if value is None:
            # A default means the value here, too: there is nobody who could override it.
            value = self.attribute(element, inner, "default")
        if value is None:
            raise LaunchError(f"Invalid <arg> tag: arg '{name}' of an <include> needs a 'value'")
        if name in inner.declared:
            raise LaunchError(f"Invalid <arg> tag: arg '{name}' has already been declared")
        inner.declared.add(name)
        inner.given[name] = value

    def _remap(self, element: Element, scope: Scope) -> None:
        old, new = self.attribute(element, scope, "from"), self.attribute(element, scope, "to")
        if not old or not new or not old.strip() or not new.strip():
            raise LaunchError("<remap> tag is missing required from/to attributes")
        scope.remappings.pop(old.strip(), None)
        scope.remappings[old.strip()] = new.strip()

    def _env(self, element: Element, scope: Scope) -> None:
        name, value = self.attribute(element, scope, "name"), self.attribute(element, scope, "value")
        if not name or value is None:
            raise LaunchError("<env> tag is missing required name/value attributes")
        if "=" in name or "\0" in name + value:
            raise LaunchError(f"an environment variable cannot be called or contain this: {name!r}")
        scope.env[name] = value

    def _param(self, element: Element, scope: Scope) -> None:
        self._params.param(element, scope, self.attribute)

    def _rosparam(self, element: Element, scope: Scope) -> None:
        self._params.rosparam(element, scope, self.attribute)

    def _machine(self, element: Element, scope: Scope) -> None:
        name, address = self.attribute(element, scope, "name"), self.attribute(element, scope, "address")
        for key, value in (("name", name), ("address", address)):
            if not value:
                raise LaunchError(f"<machine> tag is missing required attribute: '{key}'")
        for key in element.attributes:
            if key.startswith("ros-"):
                raise LaunchError(f"<machine> tag cannot have a '{key}' attribute; use 'env-loader' instead")
        default = (self.attribute(element, scope, "default") or "false").lower()
        if default not in ("true", "false", "never"):
            raise LaunchError(f"machine default must be true, false or never, not {default!r}")
        settings = tuple(
            (key, self.attribute(element, scope, key) or "")
            for key in ATTRIBUTES["machine"]
            if key in element.attributes and key not in ("name", "address")
        )
        machine = MachinePlan(name or "", address or "", settings)
        if self.plan.machines.setdefault(machine.name, machine) != machine:
            raise LaunchError(f"machine [{name}] has already been declared with other attributes")
        if default == "true":
            scope.default_machine = name


def _did_you_mean(name: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(name, list(known), 1, 0.75)
    return f" (did you mean '{close[0]}'?)" if close else ""


def absolute_files(files: Sequence[str]) -> list[str]:
    """Return the paths as ``--files`` prints them: absolute, in the order read, each once."""
    return list(dict.fromkeys(os.path.abspath(file) for file in files if file != "<stdin>"))
