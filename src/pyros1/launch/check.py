"""What a plan needs and this machine does not have."""

from __future__ import annotations

from collections.abc import Iterator

from pyros1.errors import LaunchError, PackageNotFoundError
from pyros1.launch.command_line import locate
from pyros1.launch.plan import NodePlan, Plan
from pyros1.launch.resources import PackageFinder
from pyros1.launch.suggest import did_you_mean
from pyros1.net.hosts import is_local


def unknown_machines(plan: Plan) -> Iterator[LaunchError]:
    """Yield an error for each node whose machine is not declared."""
    for node in [*plan.nodes, *plan.tests]:
        if node.machine is not None and node.machine not in plan.machines:
            hint = did_you_mean(node.machine, plan.machines)
            yield _error(node, f"unknown machine [{node.machine}]{hint}")


def check_machines(plan: Plan) -> None:
    """Raise the first error of `unknown_machines`: no node is started if there is one (X62)."""
    for error in unknown_machines(plan):
        raise error


def is_remote(plan: Plan, node: NodePlan) -> bool:
    """Return whether a node is to run on another machine."""
    machine = plan.machines.get(node.machine or "")
    return machine is not None and not is_local(machine.address)


def missing_parts(plan: Plan, packages: PackageFinder) -> Iterator[LaunchError]:
    """Yield an error for each machine, package and executable that a node needs and that is not there.

    What is on other machines is not looked for.
    """
    yield from unknown_machines(plan)
    for node in [*plan.nodes, *plan.tests]:
        if is_remote(plan, node):
            continue
        try:
            locate(node.package, node.type, packages)
        except LaunchError as error:
            yield _error(node, f"{error}{_hint(node, packages)}")


def _hint(node: NodePlan, packages: PackageFinder) -> str:
    try:
        return did_you_mean(node.type, packages.executables(node.package))
    except PackageNotFoundError:
        return did_you_mean(node.package, packages.list())


def _error(node: NodePlan, text: str) -> LaunchError:
    return LaunchError(f"node [{node.full_name}]: {text}", node.file, node.line)
