"""The queries of ``pyros1 launch``, which print information about launch files and start nothing (X06)."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.invocation import called_as
from pyros1.ground.errors import Error, LaunchError
from pyros1.ground.names import canonicalize_name, ns_join
from pyros1.ground.suggest import did_you_mean
from pyros1.launch.plan import NodePlan, Plan
from pyros1.launch.reading.loader import absolute_files, load_plan
from pyros1.launch.reading.resources import Resources


def print_problems(files: list[str], arguments: dict[str, str], resources: Resources) -> int:
    """Print every problem with launch files, including missing packages and executables. Return the exit code."""
    from pyros1.launch.running.check import plan_errors, python_node_errors  # noqa: PLC0415 - only some queries need it

    problems: list[LaunchError] = []
    plan = load_plan(files, arguments, resources, problems=problems)
    texts = [*map(str, problems), *plan.warnings, *map(str, plan_errors(plan, resources.packages, resources.environ))]
    if not called_as("roslaunch-check"):
        texts += map(str, python_node_errors(plan, resources.packages, resources.environ))
    for text in texts:
        print(text)
    if not texts:
        counts = {"file": len(plan.files), "node": len(plan.nodes), "parameter": len(plan.params)}
        print("no problems: " + ", ".join(f"{count} {noun}{'s' * (count != 1)}" for noun, count in counts.items()))
    return 1 if texts else 0


def print_answer(files: list[str], arguments: dict[str, str], resources: Resources, options: Any) -> int:
    """Print the result of a query (X06), which needs no master. Return the exit code."""
    only_args = options.ros_args and not (options.dump_params or options.file_list)
    try:
        plan = load_plan(files, arguments, resources, only_args=only_args)
    except Error as error:
        # The parameters are unknown, but scripts rely on exit code 0 of this query (X04).
        if not options.dump_params or options.node_args or options.find_node:
            raise
        print(f"Unable to load file {', '.join(files)}: {error}", file=sys.stderr)
        return 0
    if options.node_args:
        from pyros1.launch.reading import report  # noqa: PLC0415 - only some queries need it
        from pyros1.launch.running.command_line import locate, node_words  # noqa: PLC0415

        node = _find_node(plan, options.node_args, files, resources)
        executable = locate(node.package, node.type, resources.packages)
        print(report.node_args(node, node_words(node, executable, resources.environ), resources.environ))
    elif options.find_node:
        try:
            print(_find_node(plan, options.find_node, files, resources).file)
        except LookupError as error:  # scripts rely on exit code 0 of this query
            print(f"ERROR: {error}\nRun \n\troslaunch --nodes <files>\nto see list of node names.", file=sys.stderr)
    else:
        print(_result_text(plan, options))
    return 0


def _result_text(plan: Plan, options: Any) -> str:
    if options.file_list and not options.dump_params:
        return _format_names(absolute_files(plan.files), options)
    if options.dump_params or options.ros_args:
        from pyros1.launch.reading import report  # noqa: PLC0415 - only some queries need it

        return report.dump_params(plan) if options.dump_params else report.ros_args(plan)
    if options.graph or options.tree:
        from pyros1.launch.reading import drawing  # noqa: PLC0415 - only some queries need it

        return drawing.dot_text(plan) if options.graph else drawing.tree_text(plan)
    return _format_names([node.full_name for node in [*plan.nodes, *plan.tests]], options)


def _format_names(names: list[str], options: Any) -> str:
    if not options.json:
        return "\n".join(names)
    import json  # noqa: PLC0415 - rarely needed

    return json.dumps(names, ensure_ascii=False)


class _UnknownNodeError(LaunchError, LookupError):
    """No node has the requested name."""


def _find_node(plan: Plan, name: str, files: list[str], resources: Resources) -> NodePlan:
    # Nodes may have illegal names, which the usual function for resolving names rejects.
    full_name = canonicalize_name(ns_join("/" + resources.environ.get("ROS_NAMESPACE", ""), name))
    matches = [node for node in [*plan.nodes, *plan.tests] if node.full_name == full_name]
    if not matches:
        node_names = [node.full_name for node in [*plan.nodes, *plan.tests]]
        rows = "\n".join(f" * {node_name}" for node_name in node_names)
        raise _UnknownNodeError(
            f"Cannot find node named [{full_name}] in [{', '.join(files)}]{did_you_mean(full_name, node_names)}.\n"
            f"Node names are:\n{rows}"
        )
    if len(matches) > 1:
        raise LaunchError(f"multiple nodes named [{full_name}] in [{', '.join(files)}]: give them different names")
    return matches[0]
