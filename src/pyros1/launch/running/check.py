"""Checks a plan before it is run: finds missing machines, packages and programs, and other errors."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from pyros1.finding.nodelet_programs import NodeletError, check_arguments, is_throttle, locate_nodelet
from pyros1.ground.errors import Error, LaunchError, PackageNotFoundError, SerializationError
from pyros1.ground.names import parse_arguments
from pyros1.ground.suggest import did_you_mean
from pyros1.ground.timing import Time
from pyros1.launch.plan import NodePlan, Plan
from pyros1.launch.reading.resources import PackageFinder
from pyros1.launch.running.command_line import check_prefix, check_script, is_own, locate
from pyros1.launch.running.python_files import python_problems
from pyros1.net.hosts import is_local
from pyros1.wire.xmlrpc import dumps_call


def unknown_machines(plan: Plan) -> Iterator[LaunchError]:
    """Yield an error for each node whose machine is undeclared or has no address."""
    for node in [*plan.nodes, *plan.tests]:
        if node.machine is not None and node.machine not in plan.machines:
            hint = did_you_mean(node.machine, plan.machines)
            yield _error(node, f"unknown machine [{node.machine}]{hint}")
        elif node.machine is not None and not plan.machines[node.machine].address.strip():
            yield _error(node, f"machine [{node.machine}] has no address: 'address' is empty in its <machine> tag")


def check_machines(plan: Plan) -> None:
    """Raise the first error found by `unknown_machines`, before any node is started (X62)."""
    for error in unknown_machines(plan):
        raise error


def is_remote(plan: Plan, node: NodePlan) -> bool:
    """Return whether a node runs on another machine."""
    machine = plan.machines.get(node.machine or "")
    return machine is not None and not is_local(machine.address)


def plan_errors(plan: Plan, packages: PackageFinder, environ: Mapping[str, str]) -> Iterator[LaunchError]:
    """Yield an error for each machine, package, program and nodelet that a node needs but that does not exist.

    Also yield errors for nodes that wait for each other, so that none ever starts, for ``on-death`` messages that
    cannot be published, and for parameters that cannot be sent to the master. Other machines are not searched.
    """
    yield from unsendable_params(plan.params)
    yield from unknown_machines(plan)
    yield from circular_waits(plan)
    for node in plan.nodes:
        try:
            check_on_death(node)
        except LaunchError as error:
            yield _error(node, str(error))
    local_nodes = [node for node in [*plan.nodes, *plan.tests] if not is_remote(plan, node)]
    for node in [*local_nodes, *(node.on_death_plan for node in plan.nodes if node.on_death_plan is not None)]:
        executable = None
        try:
            executable = locate(node.package, node.type, packages)
        except LaunchError as error:
            yield _error(node, f"{error}{similar_executable_hint(node, packages)}")
        try:
            if executable is not None:
                check_script(node, executable, environ)
                check_nodelet(node, executable, packages)
            check_prefix(node, environ)
        except LaunchError as error:
            yield _error(node, str(error))


def python_node_errors(plan: Plan, packages: PackageFinder, environ: Mapping[str, str]) -> Iterator[LaunchError]:
    """Yield an error for each syntax error and each missing import in the Python nodes that run on this machine.

    Stock ROS has no such check. The programs are not executed.
    """
    nodes: dict[Path, NodePlan] = {}
    for node in [*plan.nodes, *plan.tests]:
        with suppress(LaunchError, PackageNotFoundError):  # reported by `plan_errors`
            if not is_remote(plan, node) and not any("python" in os.path.basename(word) for word in node.prefix):
                nodes.setdefault(locate(node.package, node.type, packages), node)
    for problem in python_problems({file: {**environ, **node.env} for file, node in nodes.items()}):
        yield _error(nodes[problem.file], f"it cannot run: {problem.text}")


def check_nodelet(node: NodePlan, executable: Path, packages: PackageFinder) -> None:
    """If a node runs pyros1's program ``nodelet``, check its arguments, and that a program replaces the nodelet.

    Raises:
        LaunchError: the arguments are invalid, or there is no such program.
    """
    if node.package != "nodelet" or not is_own(executable):
        return
    words = [word for word in parse_arguments(node.args).rest if word != "--no-bond"]
    try:
        check_arguments(words)
        if words[0] in ("load", "standalone") and not is_throttle(words[1]):  # `nodelet` does the throttling itself
            locate_nodelet(words[1], packages.executables)
    except NodeletError as error:
        raise LaunchError(str(error)) from error


def check_on_death(node: NodePlan) -> None:
    """Check that a node's ``on-death`` message can be published, since an error when the node exits would be too late.

    Raises:
        LaunchError: the type is unknown, or the values do not fit.
    """
    if node.on_death is None or node.on_death.kind != "pub":
        return
    from pyros1.msgs import load_message  # noqa: PLC0415 - few launches need it
    from pyros1.msgs.fill import fill_message  # noqa: PLC0415
    from pyros1.values import load_yaml  # noqa: PLC0415

    _, type_name, *values = node.on_death.words
    try:
        message_class = load_message(type_name)
        message = message_class()
        fill_message(message, [load_yaml(value) for value in values], Time())
        message_class._encode(message)
    except Error as error:
        raise LaunchError(f"on-death '{node.on_death}': {error}") from error


def unsendable_params(params: Mapping[str, Any]) -> Iterator[LaunchError]:
    """Yield an error for each parameter whose value cannot be sent, such as a date in a YAML file."""
    for name, value in params.items():
        try:
            dumps_call("setParam", (name, value))
        except SerializationError as error:
            yield LaunchError(f"parameter {name}: {error}; put it in quotes to make it a string")


def circular_waits(plan: Plan) -> Iterator[LaunchError]:
    """Yield an error for each node that waits for itself, directly or through other nodes."""
    waits = {
        node.full_name: [condition.name for condition in node.wait_for if condition.kind == "node"]
        for node in plan.nodes
    }
    for node in plan.nodes:
        chain = _find_cycle(node.full_name, waits)
        if chain:
            yield _error(node, f"it can never start: it waits for itself ({' -> '.join(chain)})")


def _find_cycle(start: str, waits: Mapping[str, list[str]]) -> list[str]:
    """Return the chain of nodes that wait for each other, from a node back to itself; an empty list if there is
    none.
    """
    paths = [[start]]
    visited: set[str] = set()
    while paths:
        path = paths.pop()
        for name in waits.get(path[-1], ()):
            if name == start:
                return [*path, start]
            if name not in visited:
                visited.add(name)
                paths.append([*path, name])
    return []


def similar_executable_hint(node: NodePlan, packages: PackageFinder) -> str:
    """Return a hint for a misspelt package or type, or an empty string if no name is similar."""
    try:
        return did_you_mean(node.type, packages.executables(node.package))
    except PackageNotFoundError:
        return did_you_mean(node.package, packages.list())


def _error(node: NodePlan, text: str) -> LaunchError:
    return LaunchError(f"node [{node.full_name}]: {text}", node.file, node.line)
