"""Converts pyros1's plans of launches to the objects of roslaunch, and back."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import MachinePlan, NodePlan, Plan, TestPlan
from pyros1.launch.scripting import Node as ScriptNode
from roslaunch.core import Machine, Node, Test


def to_node(plan: NodePlan) -> Node:
    """Return the Node for a node in a plan."""
    options: dict[str, Any] = {
        "name": plan.name,
        "namespace": plan.namespace,
        "machine_name": plan.machine,
        "args": plan.args_text,
        "remap_args": [list(pair) for pair in plan.remappings],
        "env_args": list(plan.env.items()),
        "cwd": "node" if plan.cwd == "node" else None,
        "launch_prefix": plan.prefix_text,
        "filename": plan.file,
    }
    if isinstance(plan, TestPlan):
        node: Node = Test(
            plan.test_name, plan.package, plan.type, time_limit=plan.time_limit, retry=plan.retry, **options
        )
    else:
        node = Node(
            plan.package,
            plan.type,
            **asdict(plan.exit_policy),
            output="screen" if plan.output == "screen" else None,
            **options,
        )
    node.source_plan = plan
    return node


def to_node_plan(node: Node) -> NodePlan:
    """Return the plan of a Node, with the program's changes to it; raise LaunchError if it cannot be launched."""
    script_node = ScriptNode(
        node.package,
        node.type,
        name=node.name,
        namespace=node.namespace,
        args=node.args,
        respawn=node.respawn,
        respawn_delay=node.respawn_delay,
        remap_args=node.remap_args,
        env_args=node.env_args,
        output=node.output,
        cwd=node.cwd,
        launch_prefix=node.launch_prefix,
        required=node.required,
        filename=node.filename,
    )
    script_node.plan.machine = node.machine_name
    if node.source_plan is not None:
        script_node.plan.line = node.source_plan.line
        script_node.plan.wait_for, script_node.plan.wait_timeout = (
            node.source_plan.wait_for,
            node.source_plan.wait_timeout,
        )
    return script_node.plan


def to_machine(plan: MachinePlan) -> Machine:
    """Return the Machine for a machine in a plan."""
    settings = dict(plan.settings)
    return Machine(
        plan.name,
        plan.address,
        env_loader=settings.get("env-loader") or None,
        ssh_port=int(settings.get("ssh-port") or 22),
        user=settings.get("user"),
        password=settings.get("password"),
        assignable=settings.get("default", "").lower() != "never",
        timeout=float(settings.get("timeout") or 10.0),
    )


def to_machine_plan(machine: Machine) -> MachinePlan:
    """Return the plan of a Machine."""
    settings = {"env-loader": machine.env_loader, "user": machine.user, "password": machine.password}
    settings |= {"ssh-port": str(machine.ssh_port), "timeout": str(machine.timeout)}
    return MachinePlan(machine.name, machine.address, tuple((key, value) for key, value in settings.items() if value))


def to_plan(config: Any) -> Plan:
    """Return the plan of a ROSLaunchConfig.

    Raises:
        LaunchError: the ROSLaunchConfig contains nodes that cannot be launched.
    """
    if config.executables:
        raise LaunchError(f"pyros1 cannot run executables in addition to nodes: {config.executables[0]}")
    plan = Plan(actions=list(config.actions), files=list(config.roslaunch_files))
    plan.nodes = [to_node_plan(node) for node in config.nodes]
    plan.params = {name: param.value for name, param in config.params.items()}
    plan.clear_params = list(config.clear_params)
    plan.machines = {name: to_machine_plan(machine) for name, machine in config.machines.items() if name}
    return plan
