"""``<node>`` and ``<test>`` (https://wiki.ros.org/roslaunch/XML/node, https://wiki.ros.org/roslaunch/XML/test)."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import Literal

from pyros1.errors import LaunchError
from pyros1.launch.convert import convert_bool
from pyros1.launch.document import Element
from pyros1.launch.params import Attribute, ParamReader
from pyros1.launch.plan import NodePlan, Plan
from pyros1.launch.scope import Scope
from pyros1.names import is_legal_base_name, ns_join

Children = Callable[[Element, Scope, dict[str, Callable[[Element, Scope], None]]], None]
_NOT_ON_TEST = ("respawn", "respawn_delay", "output", "required")


class NodeReader:
    """Adds nodes to a plan.

    Args:
        plan: the plan.
        params: adds the parameters inside a node tag.
        attribute: reads attributes.
        children: handles tags inside a tag.
    """

    def __init__(self, plan: Plan, params: ParamReader, attribute: Attribute, children: Children) -> None:
        self._plan = plan
        self._params = params
        self._attribute = attribute
        self._children = children
        self._places: dict[str, str] = {}

    def node(self, element: Element, scope: Scope) -> None:
        """Handle a ``<node>``."""
        self._invalid(element, lambda: self._read(element, scope, self._plan.nodes))

    def test(self, element: Element, scope: Scope) -> None:
        """Handle a ``<test>``: it is kept for testing, and its parameters are set."""
        for name in _NOT_ON_TEST:
            if name in element.attributes:
                raise LaunchError(f"Invalid <node> tag: <test> tags cannot have '{name}' attribute.")
        if "test-name" not in element.attributes:
            raise LaunchError("<test> tag is missing required attribute: 'test-name'")
        self._invalid(element, lambda: self._read(element, scope, self._plan.tests))

    @staticmethod
    def _invalid(element: Element, read: Callable[[], None]) -> None:
        try:
            read()
        except LaunchError as error:
            if error.line is not None or str(error).startswith(("<", "roslaunch file")):
                raise
            raise element.error(f"Invalid <node> tag: {error}") from error

    def _read(self, element: Element, scope: Scope, nodes: list[NodePlan]) -> None:
        def text(name: str) -> str | None:
            return self._attribute(element, scope, name)

        def flag(name: str) -> bool:
            value = text(name)
            return bool(value) and convert_bool(value or "", name)

        key = "test-name" if element.tag == "test" and "name" not in element.attributes else "name"
        for required in (key, "pkg", "type"):
            if required not in element.attributes:
                raise LaunchError(f"<node> tag is missing required attribute: '{required}'")
        name = (text(key) or "").strip()
        if "/" in name:
            raise LaunchError("node name cannot contain a namespace.")
        if not is_legal_base_name(name):
            raise LaunchError(f"not a legal node name: {name!r}")
        inner = scope.child(text("ns"))
        full_name = ns_join(inner.namespace, name)
        for private_name, value in scope.private_params:
            self._params.add(f"{full_name}/{private_name}", value)
        if flag("clear_params"):
            self._plan.clear_params.append(full_name + "/")
        self._children(
            element,
            inner,
            {
                "param": lambda child, at: self._params.param(child, at, self._attribute, full_name),
                "rosparam": lambda child, at: self._params.rosparam(child, at, self._attribute, full_name),
                "remap": self._remap,
                "env": self._env,
            },
        )
        package, kind = (text("pkg") or "").strip(), (text("type") or "").strip()
        if not package:
            raise LaunchError("package must be non-empty.")
        if not kind:
            raise LaunchError("type must be non-empty.")
        plan = NodePlan(
            package=package,
            type=kind,
            name=name,
            namespace=inner.namespace,
            args=_split(text("args"), "args"),
            remappings=list(inner.remappings.items()),
            env=dict(inner.env),
            prefix=_split(text("launch-prefix"), "launch-prefix"),
            cwd=self._cwd(text("cwd")),
            output=self._output(text("output")),
            respawn=flag("respawn"),
            respawn_delay=self._delay(text("respawn_delay")),
            required=flag("required"),
            machine=self._machine(text("machine"), scope),
            file=element.file,
            line=element.line,
        )
        if plan.respawn and plan.required:
            raise LaunchError("respawn and required cannot both be set to true.")
        self._check_unique(plan, element)
        nodes.append(plan)

    def _remap(self, element: Element, scope: Scope) -> None:
        old, new = self._attribute(element, scope, "from"), self._attribute(element, scope, "to")
        if not old or not new:
            raise LaunchError("<remap> tag is missing required from/to attributes")
        scope.remappings.pop(old.strip(), None)
        scope.remappings[old.strip()] = new.strip()

    def _env(self, element: Element, scope: Scope) -> None:
        name, value = self._attribute(element, scope, "name"), self._attribute(element, scope, "value")
        if not name or value is None:
            raise LaunchError("<env> tag is missing required name/value attributes")
        scope.env[name] = value

    def _check_unique(self, plan: NodePlan, element: Element) -> None:
        place = f"{element.file}:{element.line}"
        first = self._places.setdefault(plan.full_name, place)
        if first is not place:
            raise LaunchError(
                f"roslaunch file contains multiple nodes named [{plan.full_name}].\n"
                f"The other one is at {first}. Give them different names; $(anon id) makes a name unique."
            )

    def _machine(self, name: str | None, scope: Scope) -> str | None:
        if not name:
            return scope.default_machine
        if name not in self._plan.machines:
            self._plan.warnings.append(f"unknown machine [{name}]: its nodes are started on this one")
            return None
        return name

    @staticmethod
    def _cwd(text: str | None) -> Literal["ros_home", "node"]:
        if not text or text.strip().lower() in ("ros_home", "ros-root"):
            return "ros_home"
        if text.strip().lower() == "node":
            return "node"
        raise LaunchError("cwd must be one of 'ROS_HOME', 'node'.")

    @staticmethod
    def _output(text: str | None) -> Literal["log", "screen"]:
        if not text or text.strip() == "log":
            return "log"
        if text.strip() == "screen":
            return "screen"
        raise LaunchError("output must be one of 'log', 'screen'.")

    @staticmethod
    def _delay(text: str | None) -> float:
        if not text:
            return 0.0
        try:
            delay = float(text)
        except ValueError as error:
            raise LaunchError(f"invalid float value for respawn_delay: {text}") from error
        return min(max(delay, 0.0), 86400.0)


def _split(text: str | None, attribute: str) -> list[str]:
    try:
        return shlex.split(text or "")
    except ValueError as error:
        raise LaunchError(f"cannot split the {attribute} attribute: {error} in {text!r}") from error
