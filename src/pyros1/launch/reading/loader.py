"""Reads launch files into a `Plan`, tag by tag (https://wiki.ros.org/roslaunch/XML).

Each tag has a handler method, which is called with the element and its scope, and adds what it reads to the plan.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence

from pyros1.ground.errors import Error, LaunchError
from pyros1.ground.suggest import did_you_mean
from pyros1.launch.plan import ArgPlan, IncludePlan, Plan
from pyros1.launch.reading.convert import convert_bool, convert_condition
from pyros1.launch.reading.document import Element, parse_document
from pyros1.launch.reading.machines import SETTING_NAMES, read_machine
from pyros1.launch.reading.nodes import NodeReader
from pyros1.launch.reading.params import ParamReader
from pyros1.launch.reading.resources import Resources
from pyros1.launch.reading.scope import Scope, ScopeSubstituter
from pyros1.launch.reading.substitution import substitute

STDIN_NAME = "-"
_Handlers = dict[str, Callable[[Element, Scope], None]]
_REPEATEDLY = " (repeatedly)"
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
    "wait-for",
    "wait-timeout",
)
_TEST_ATTRIBUTES = (*_NODE_ATTRIBUTES, "test-name", "cwd", "launch-prefix")
ATTRIBUTES_BY_TAG: dict[str, tuple[str, ...]] = {
    "launch": ("deprecated",),
    "arg": ("name", "value", "default", "doc"),
    "include": ("file", "ns", "clear_params", "pass_all_args"),
    "group": ("ns", "clear_params", "wait-for", "wait-timeout"),
    "node": (*_NODE_ATTRIBUTES, "on-death", "priority", "output", "cwd", "launch-prefix"),
    "test": (*_TEST_ATTRIBUTES, "time-limit", "retry"),
    "param": ("name", "value", "textfile", "binfile", "command", "type"),
    "rosparam": ("command", "file", "param", "ns", "subst_value"),
    "remap": ("from", "to"),
    "env": ("name", "value"),
    "machine": ("name", "address", *SETTING_NAMES),
}
"""The attributes of each tag, except if and unless."""


def load_plan(
    files: Sequence[str],
    arguments: Mapping[str, str],
    resources: Resources,
    *,
    only_args: bool = False,
    problems: list[LaunchError] | None = None,
    plan: Plan | None = None,
) -> Plan:
    """Read launch files into one plan (X02, X03).

    Args:
        files: paths; ``-`` is standard input.
        arguments: the ``name:=value`` arguments on the command line, which apply to every file. ``__ns`` is the
            namespace of everything (default: ``ROS_NAMESPACE``).
        resources: access to files, packages and the environment.
        only_args: whether to read only the ``<arg>`` tags at the top level of the files; these then need no values.
        problems: a list to which all errors are added; reading continues after the element with the error. None to
            raise the first error.
        plan: the plan to add to; None for a new plan.

    Returns:
        The plan.

    Raises:
        LaunchError: a file cannot be used. The message contains the file, the line and the chain of includes.
    """
    loader = _Loader(resources, only_args, problems, plan or Plan())
    for file in files:
        loader.read_top_level(file, arguments)
    loader.report_unused(arguments)
    return loader.plan


class _Loader:
    def __init__(self, resources: Resources, only_args: bool, problems: list[LaunchError] | None, plan: Plan) -> None:
        self.plan = plan
        self._resources = resources
        self._only_args = only_args
        self._problems = problems
        self._depth = 0
        self._too_deep_files: set[str] = set()
        self._known_args: set[str] = set()
        self._params = ParamReader(self.plan)
        self._nodes = NodeReader(self.plan, self._params, self.attribute, self.children)
        self._handlers: _Handlers = {
            "arg": self._arg,
            "include": self._include,
            "group": self._group,
            "node": self._nodes.add_node,
            "test": self._nodes.add_test,
            "param": lambda element, scope: self._params.read_param(element, scope, self.attribute),
            "rosparam": lambda element, scope: self._params.read_rosparam(element, scope, self.attribute),
            "remap": self._remap,
            "env": self._env,
            "machine": self._machine,
        }

    def read_top_level(self, file: str, arguments: Mapping[str, str]) -> None:
        """Read a file that was specified by the user."""
        name = "<stdin>" if file == STDIN_NAME else file
        try:
            root = parse_document(self._resources.read_stdin() if file == STDIN_NAME else self._read(file), name)
        except LaunchError as error:
            self._report(error)
            return
        self.plan.files.append(name)
        self.plan.args.clear()  # only the last file's arguments are documented
        scope = Scope(self._resources, name, args=dict(arguments), known_args=self._known_args)
        namespace = arguments.get("__ns") or self._resources.environ.get("ROS_NAMESPACE")
        self._read_root(root, scope.child("/" + namespace) if namespace else scope)

    def report_unused(self, arguments: Mapping[str, str]) -> None:
        """Warn about arguments that are declared in no file, as they may be misspelt."""
        if not self._only_args:
            for name in arguments:
                if name not in self._known_args and not name.startswith("__"):
                    self.plan.warnings.append(f"unused arg '{name}'{did_you_mean(name, self._known_args)}")

    def _report(self, error: LaunchError) -> None:
        if self._problems is None:
            raise error
        self._problems.append(error)

    def _read(self, file: str) -> bytes:
        try:
            return self._resources.read_bytes(file)
        except OSError as error:
            raise LaunchError(
                f"cannot read [{file}]: {error.strerror}{self._resources.similar_file_hint(file)}"
            ) from error

    def _read_root(self, root: Element, scope: Scope) -> None:
        self._check_attributes(root, scope)
        if root.attributes.get("deprecated"):  # without substitution
            self.plan.warnings.append(f"[{scope.file}] DEPRECATED: {root.attributes['deprecated']}")
        self.children(root, scope, self._handlers)

    # Shared by all tags --------------------------------------------------------------------------------------------

    def children(self, parent: Element, scope: Scope, handlers: _Handlers) -> None:
        """Handle the children of `parent`. Tags without a handler only cause a warning (X56)."""
        for element in parent.children:
            # Tags inside <node> and <include> may be in upper case.
            handler = handlers.get(element.tag if handlers is self._handlers else element.tag.lower())
            if self._only_args and element.tag != "arg":
                continue
            if handler is None:
                self._unknown_tag(element, parent, handlers)
                continue
            try:
                if self._applies(element, scope):
                    self._check_attributes(element, scope)
                    handler(element, scope)
            except Error as error:
                if isinstance(error, LaunchError) and error.line is not None:
                    self._report(error)
                else:
                    located_error = element.error(str(error))
                    located_error.__cause__ = error
                    self._report(located_error)

    def _unknown_tag(self, element: Element, parent: Element, handlers: _Handlers) -> None:
        if element.tag == "master" and parent.tag == "launch":
            self.plan.warnings.append("ignoring defunct <master /> tag")
            return
        text = f"unrecognized tag {element.tag}"
        if parent.tag != "launch":
            text = f"unrecognized '{element.tag}' child tag in the parent tag element: <{parent.tag}>"
        self.plan.warnings.append(f"[{element.place}] {text}{did_you_mean(element.tag, handlers)}")

    def _applies(self, element: Element, scope: Scope) -> bool:
        if "if" in element.attributes and "unless" in element.attributes:
            raise LaunchError("cannot set both 'if' and 'unless' on the same tag")
        if "if" in element.attributes:
            return convert_condition(self.attribute(element, scope, "if") or "")
        if "unless" in element.attributes:
            return not convert_condition(self.attribute(element, scope, "unless") or "")
        return True

    def _check_attributes(self, element: Element, scope: Scope) -> None:
        tag = element.tag.lower()
        known_names = ATTRIBUTES_BY_TAG[tag]
        for name in element.attributes:
            is_for_editors = name.startswith("xmlns") or (tag == "launch" and ":" in name)  # xsi:schemaLocation
            if name not in known_names and name not in ("if", "unless") and not is_for_editors:
                self.plan.warnings.append(
                    f"[{element.place}] unknown <{tag}> attribute '{name}'{did_you_mean(name, known_names)}"
                )

    def attribute(self, element: Element, scope: Scope, name: str) -> str | None:
        """Return an attribute after substitution; None if the element does not have it."""
        raw = element.attributes.get(name)
        return None if raw is None else substitute(raw, ScopeSubstituter(scope))

    # Tags ----------------------------------------------------------------------------------------------------------

    def _arg(self, element: Element, scope: Scope) -> None:
        name, value, default = self._declare(element, scope, scope)
        if not value and not scope.is_included:
            self.plan.args[name] = ArgPlan(name, default, self.attribute(element, scope, "doc"))

    def _declare(self, element: Element, scope: Scope, target: Scope) -> tuple[str, str | None, str | None]:
        """Read an ``<arg>`` in `scope` and declare it in `target`; return its name, value and default."""
        try:
            name = self.attribute(element, scope, "name")
            if not name:
                raise LaunchError("'name' is missing")
            if "value" in element.attributes and "default" in element.attributes:
                raise LaunchError("it must have one and only one of value/default")
            value, default = self.attribute(element, scope, "value"), self.attribute(element, scope, "default")
            target.declare(name, value, default)
        except LaunchError as error:
            raise element.error(f"Invalid <arg> tag: {error}") from error
        return name, value, default

    def _group(self, element: Element, scope: Scope) -> None:
        group_scope = scope.child(self._namespace(element, scope))
        self._clear_params(element, scope, group_scope)
        group_scope.wait_for = f"{scope.wait_for} {self.attribute(element, scope, 'wait-for') or ''}".strip()
        group_scope.wait_timeout = self.attribute(element, scope, "wait-timeout") or scope.wait_timeout
        self.children(element, group_scope, self._handlers)
        scope.default_machine = group_scope.default_machine

    def _namespace(self, element: Element, scope: Scope) -> str | None:
        namespace = self.attribute(element, scope, "ns")
        if namespace == "":
            raise LaunchError(f"<{element.tag}> tag has an empty 'ns' attribute")
        return namespace

    def _clear_params(self, element: Element, scope: Scope, inner_scope: Scope) -> None:
        text = self.attribute(element, scope, "clear_params")
        if text and convert_bool(text, "clear_params"):
            if "ns" not in element.attributes:
                raise LaunchError("'ns' attribute must be set in order to use 'clear_params'")
            self.plan.clear_params.append(inner_scope.namespace)

    def _include(self, element: Element, scope: Scope) -> None:
        file = self.attribute(element, scope, "file")
        if not file:
            raise LaunchError("<include> tag is missing required attribute: 'file'")
        pass_all_text = self.attribute(element, scope, "pass_all_args")
        has_pass_all = pass_all_text is not None and convert_bool(pass_all_text, "pass_all_args")
        inner_scope = scope.child(self._namespace(element, scope))
        self._clear_params(element, scope, inner_scope)
        args_scope = self._include_args(
            element,
            inner_scope,
            inner_scope.child(args=dict(scope.args) if has_pass_all else {}, pass_all=has_pass_all),
        )
        included = args_scope.child(
            file=file,
            is_included=True,
            args=dict(args_scope.args),
            declared=set(),
            pass_all=has_pass_all,
            anonymous_names={},
            # As in stock ROS: private parameters that an included file sets for all its nodes also apply to nodes after
            # the <include>, but only if there were such parameters before.
            private_params=scope.private_params or [],
        )
        if file in self._too_deep_files:  # already reported: a file may include itself more than once
            return
        if self._depth >= _MAX_INCLUDES:
            self._too_deep_files.add(file)
            raise LaunchError(f"includes are nested more than {_MAX_INCLUDES} deep: does [{file}] include itself?")
        root = parse_document(self._read(file), file)
        self.plan.files.append(file)
        self.plan.includes.append(IncludePlan(scope.file, element.line, file))
        self._depth += 1
        problem_count_before = len(self._problems or [])
        try:
            self._read_root(root, included)
        except LaunchError as error:
            _add_includer(error, element)
            raise
        finally:
            self._depth -= 1
        for problem in (self._problems or [])[problem_count_before:]:
            _add_includer(problem, element)
        scope.default_machine = included.default_machine
        unused = [] if has_pass_all else [name for name in args_scope.args if name not in included.declared]
        if unused:
            hint = did_you_mean(unused[0], included.declared) if len(unused) == 1 else ""
            raise LaunchError(f"unused args [{', '.join(unused)}] for include of [{file}]{hint}")

    def _include_args(self, element: Element, scope: Scope, args_scope: Scope) -> Scope:
        """Read the children of an ``<include>`` into `args_scope`: arguments with values, and environment variables."""
        args_scope.declared = set(args_scope.args)
        self.children(
            element,
            scope,
            {
                "arg": lambda child, child_scope: self._add_include_arg(child, child_scope, args_scope),
                "env": lambda child, child_scope: self._set_env(child, child_scope, args_scope),
            },
        )
        return args_scope

    def _add_include_arg(self, element: Element, scope: Scope, args_scope: Scope) -> None:
        name, *_ = self._declare(element, scope, args_scope)
        if name not in args_scope.args:
            raise LaunchError(f"Invalid <arg> tag: arg '{name}' of an <include> needs a 'value'")

    def _remap(self, element: Element, scope: Scope) -> None:
        scope.remap(self.attribute(element, scope, "from"), self.attribute(element, scope, "to"))

    def _env(self, element: Element, scope: Scope) -> None:
        self._set_env(element, scope, scope)

    def _set_env(self, element: Element, scope: Scope, target: Scope) -> None:
        target.set_env(self.attribute(element, scope, "name"), self.attribute(element, scope, "value"))

    def _machine(self, element: Element, scope: Scope) -> None:
        default = read_machine(element, lambda name: self.attribute(element, scope, name), self.plan)
        self.children(element, scope, {})
        if default is not None:
            scope.default_machine = default


def _add_includer(error: LaunchError, include: Element) -> None:
    """Append the place of an ``<include>`` to an error in the included file; only once if files include each other."""
    lines, line = str(error).split("\n"), f"  included at {include.place}"
    if line + _REPEATEDLY in lines:
        return
    if line not in lines:
        lines.append(line)
    elif not lines[-1].endswith(_REPEATEDLY):
        lines[-1] += _REPEATEDLY
    error.args = ("\n".join(lines),)


def absolute_files(files: Sequence[str]) -> list[str]:
    """Return the paths that ``--files`` prints: absolute, in reading order, without duplicates."""
    return [os.path.abspath(file) for file in dict.fromkeys(files) if file != "<stdin>"]
