"""Reads ``<node>`` and ``<test>`` tags
(https://wiki.ros.org/roslaunch/XML/node, https://wiki.ros.org/roslaunch/XML/test).
"""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import Literal

from pyros1.ground.errors import LaunchError
from pyros1.ground.names import is_legal_base_name
from pyros1.ground.realtime import check_priority
from pyros1.launch.plan import ExitPolicy, NodePlan, Plan, TestPlan
from pyros1.launch.reading.conditions import parse_conditions, parse_seconds
from pyros1.launch.reading.convert import convert_bool
from pyros1.launch.reading.document import Element
from pyros1.launch.reading.on_death import parse_on_death
from pyros1.launch.reading.params import Attribute, ParamReader
from pyros1.launch.reading.scope import Scope

Children = Callable[[Element, Scope, dict[str, Callable[[Element, Scope], None]]], None]
_ATTRIBUTES_NOT_FOR_TESTS = ("respawn", "respawn_delay", "output", "on-death", "priority")


class NodeReader:
    """Adds nodes to a plan.

    Args:
        plan: the plan to add nodes to.
        params: adds parameters to the plan.
        attribute: returns the value of an element's attribute.
        children: handles the children of an element.
    """

    def __init__(self, plan: Plan, params: ParamReader, attribute: Attribute, children: Children) -> None:
        self._plan = plan
        self._params = params
        self._attribute = attribute
        self._children = children
        self._node_locations: dict[str, str] = {}

    def add_node(self, element: Element, scope: Scope) -> None:
        """Handle a ``<node>``: add it to the plan's nodes, and its parameters to the plan."""
        self._with_node_errors(element, lambda: self._plan.nodes.append(self._read(element, scope)))

    def add_test(self, element: Element, scope: Scope) -> None:
        """Handle a ``<test>``: add it to the plan's tests, and its parameters to the plan."""
        for name in _ATTRIBUTES_NOT_FOR_TESTS:
            if name in element.attributes:
                raise LaunchError(f"Invalid <node> tag: <test> tags cannot have '{name}' attribute.")
        if "test-name" not in element.attributes:
            raise LaunchError("<test> tag is missing required attribute: 'test-name'")
        self._with_node_errors(element, lambda: self._plan.tests.append(self._read_test(element, scope)))

    @staticmethod
    def _with_node_errors(element: Element, read: Callable[[], None]) -> None:
        try:
            read()
        except LaunchError as error:
            if error.line is not None or str(error).startswith(("<", "roslaunch file")):
                raise
            raise element.error(f"Invalid <node> tag: {error}") from error

    def _read_test(self, element: Element, scope: Scope) -> TestPlan:
        node = self._read(element, scope)
        name = (self._attribute(element, scope, "test-name") or "").strip()
        if not name:
            raise LaunchError("'test-name' must be non-empty")
        time_limit, retry = self._attribute(element, scope, "time-limit"), self._attribute(element, scope, "retry")
        test = TestPlan(**vars(node), test_name=name)
        if time_limit:
            test.time_limit = parse_seconds(time_limit, "time-limit")
            if not test.time_limit:
                raise LaunchError("'time-limit' must be a positive number")
        if retry:
            try:
                test.retry = max(0, int(retry))
            except ValueError as error:
                raise LaunchError(f"'retry' must be a whole number, not {retry!r}") from error
        return test

    def _read(self, element: Element, scope: Scope) -> NodePlan:
        def text(name: str) -> str | None:
            return self._attribute(element, scope, name)

        def flag(name: str) -> bool:
            value = text(name)
            return value is not None and convert_bool(value, name)

        name_attribute = "test-name" if element.tag == "test" and "name" not in element.attributes else "name"
        for required in (name_attribute, "pkg", "type"):
            if required not in element.attributes:
                raise LaunchError(f"<node> tag is missing required attribute: '{required}'")
        name = text(name_attribute) or (text("test-name") if element.tag == "test" else "") or ""
        if "/" in name:
            raise LaunchError("node name cannot contain a namespace.")
        if not name:
            raise LaunchError('name must be non-empty. For an arbitrary name use name="$(anon node)".')
        if not is_legal_base_name(name):
            self._plan.warnings.append(
                f"[{element.place}] illegal <node> name '{name}': this will likely cause problems with other ROS tools"
            )
        if "ns" in element.attributes and not text("ns"):
            raise LaunchError(f"<{element.tag}> tag has an empty 'ns' attribute")
        node_scope = scope.child(text("ns"))
        if text("clear_params") and flag("clear_params"):  # an empty value means false only for clear_params
            self._plan.clear_params.append(node_scope.child(name).namespace)
        self._read_children(element, node_scope, name)
        package, node_type = text("pkg") or "", text("type") or ""
        if not package.strip():
            raise LaunchError("package must be non-empty.")
        if not node_type.strip():
            raise LaunchError("type must be non-empty.")
        plan = NodePlan(
            package=package,
            type=node_type,
            name=name,
            namespace=node_scope.namespace,
            args=_split(text("args"), "args"),
            remappings=list(node_scope.remappings.items()),
            env=dict(node_scope.env),
            prefix=_split(text("launch-prefix"), "launch-prefix"),
            cwd=self._parse_cwd(text("cwd")),
            output=self._parse_output(text("output")),
            exit_policy=ExitPolicy(flag("respawn"), self._parse_delay(text("respawn_delay")), flag("required")),
            machine=text("machine") or scope.default_machine,
            file=element.file,
            line=element.line,
            args_text=text("args") or "",
            prefix_text=text("launch-prefix") or "",
        )
        wait_for = f"{scope.wait_for} {text('wait-for') or ''}"
        plan.wait_for = list(dict.fromkeys(parse_conditions(wait_for, node_scope.namespace, name)))
        wait_timeout = text("wait-timeout") or scope.wait_timeout
        if wait_timeout:
            plan.wait_timeout = parse_seconds(wait_timeout, "wait-timeout")
        on_death = text("on-death") or ""
        plan.on_death = parse_on_death(on_death, node_scope.namespace, name, plan.remappings)
        plan.priority = self._parse_priority(text("priority"))
        if plan.exit_policy.respawn and plan.exit_policy.required:
            raise LaunchError("respawn and required cannot both be set to true.")
        if element.tag == "node":  # tests run one at a time
            self._check_unique(plan, element)
        return plan

    def _read_children(self, element: Element, scope: Scope, name: str) -> None:
        def attribute(child: Element, attribute_name: str) -> str | None:
            return self._attribute(child, scope, attribute_name)

        node_scope = scope.child(name, private_params=[])
        self._children(
            element,
            scope,
            {
                "param": lambda child, _: self._params.read_param(child, node_scope, self._attribute, private=True),
                "rosparam": lambda child, _: self._params.read_rosparam(child, node_scope, self._attribute),
                "remap": lambda child, _: scope.remap(attribute(child, "from"), attribute(child, "to")),
                "env": lambda child, _: scope.set_env(attribute(child, "name"), attribute(child, "value")),
            },
        )
        # Parameters of the scope override the <rosparam> tags of the node, and are overridden by its <param> tags.
        for private_name, value in [*scope.private_params, *node_scope.private_params]:
            self._params.add(node_scope.namespace + private_name, value)

    def _check_unique(self, plan: NodePlan, element: Element) -> None:
        first_location = self._node_locations.setdefault(plan.full_name, location := element.place)
        if first_location is not location:
            raise LaunchError(
                f"roslaunch file contains multiple nodes named [{plan.full_name}].\n"
                f"The other one is at {first_location}. Give them different names; $(anon id) makes a name unique."
            )

    @staticmethod
    def _parse_cwd(text: str | None) -> Literal["ros_home", "node"]:
        if text in (None, "ros_home", "ROS_HOME"):
            return "ros_home"
        if text == "node":
            return "node"
        raise LaunchError("cwd must be one of 'ROS_HOME', 'node'.")

    @staticmethod
    def _parse_output(text: str | None) -> Literal["log", "screen"]:
        if text in (None, "log"):
            return "log"
        if text == "screen":
            return "screen"
        raise LaunchError("output must be one of 'log', 'screen'.")

    @staticmethod
    def _parse_priority(text: str | None) -> int:
        if not text:
            return 0
        try:
            return check_priority(text, "priority")
        except ValueError as error:
            raise LaunchError(str(error)) from error

    @staticmethod
    def _parse_delay(text: str | None) -> float:
        if text is None:
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
        raise LaunchError(f"cannot split the '{attribute}' attribute into arguments: {error} in {text!r}") from error
