"""Formats a plan as text: the SUMMARY block, and the output of queries (X82, L147-L173)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pyros1.launch.plan import NodePlan, Plan
from pyros1.net.hosts import DEFAULT_MASTER_URI, is_local

_MAX_VALUE_LENGTH = 20


def summary(plan: Plan, extra_params: Mapping[str, Any] | None = None, machines: Iterable[str] | None = None) -> str:
    """Return the SUMMARY block, which is printed before anything is started.

    Args:
        plan: the plan to summarise.
        extra_params: the core's parameters, which are listed as well.
        machines: names of the machines to list; None for all machines if any node runs on another machine, else none.
    """
    lines = ["", "SUMMARY", "========"]
    if plan.clear_params:
        lines += ["", "CLEAR PARAMETERS", *(f" * {name}" for name in sorted(plan.clear_params))]
    params = {**(extra_params or {}), **plan.params}
    if params:
        lines += ["", "PARAMETERS", *sorted(f" * {name}: {_format_value(value)}" for name, value in params.items())]
    if machines is None:
        used_machines = {plan.machines[node.machine] for node in plan.nodes if node.machine in plan.machines}
        machines = plan.machines if any(not is_local(machine.address) for machine in used_machines) else ()
    if machines:
        lines += ["", "MACHINES", *(f" * {name}" for name in sorted(machines))]
    lines += ["", "NODES"]
    by_namespace: dict[str, list[NodePlan]] = {}
    for node in plan.nodes:
        by_namespace.setdefault(node.namespace, []).append(node)
    for namespace in sorted(by_namespace):
        lines.append(f"  {namespace}")
        lines += sorted(f"    {node.name} ({node.package}/{node.type})" for node in by_namespace[namespace])
    return "\n".join([*lines, ""])


def list_contents(plan: Plan) -> str:
    """Return one line for each file, parameter, machine and node that was read (``-v``, L162)."""
    from pyros1.launch.reading.loader import absolute_files  # noqa: PLC0415 - only needed here

    lines = [f"... loading XML file [{file}]" for file in absolute_files(plan.files)]
    lines += [f"Added parameter [{name}]" for name in plan.params]
    lines += [f"Added machine [{machine}]" for machine in plan.machines]
    lines += [f"Added node of type [{node.package}/{node.type}] in namespace [{node.namespace}]" for node in plan.nodes]
    return "\n".join(lines)


def _format_value(value: Any) -> str:
    text = value.decode("latin-1") if isinstance(value, bytes) else str(value)
    if len(text) > _MAX_VALUE_LENGTH:
        text = text[: _MAX_VALUE_LENGTH - 3] + "..."
    if text.isascii() and text.isprintable():
        return text
    text = text.rstrip()
    return text if text.isascii() and text.isprintable() else "<...>"


def dump_params(plan: Plan) -> str:
    """Return all parameters as YAML (``--dump-params``)."""
    from pyros1.values import dump_yaml  # noqa: PLC0415 - only needed here

    return dump_yaml(plan.params)


def ros_args(plan: Plan) -> str:
    """Return the documentation of the arguments (``--ros-args``)."""
    required = [arg for arg in plan.args.values() if not arg.default]
    optional = [arg for arg in plan.args.values() if arg.default]
    lines: list[str] = []
    if required:
        lines += ["Required Arguments:", *sorted(f"  {arg.name}: {arg.doc or 'undocumented'}" for arg in required)]
    if optional:
        lines.append("Optional Arguments:")
        lines += sorted(f'  {arg.name} (default "{arg.default}"): {arg.doc or "undocumented"}' for arg in optional)
    return "\n".join(lines or ["No arguments."])


def node_args(node: NodePlan, words: list[str], environ: Mapping[str, str]) -> str:
    """Return the environment and command line of a node (``--args``); see `node_arg_words`."""
    return " ".join(node_arg_words(node, words, environ))


def node_arg_words(node: NodePlan, words: list[str], environ: Mapping[str, str]) -> list[str]:
    """Return the environment variables and command line of a node, as a list of words.

    Args:
        node: the planned node.
        words: the node's command line, without ``__log``.
        environ: this process's environment; only variables that differ from it are included.
    """
    env = dict(environ)  # these variables come first, in their order
    env.pop("ROS_NAMESPACE", None)
    if not environ.get("ROS_MASTER_URI"):
        env["ROS_MASTER_URI"] = f"{DEFAULT_MASTER_URI}/"
    if node.namespace.strip("/"):
        env["ROS_NAMESPACE"] = node.namespace.rstrip("/")
    env.update(node.env)
    changed = (f'{name}="{value}"' for name, value in env.items() if environ.get(name) != value)
    return [*changed, *words]
