"""The queries that ``pyros1 launch`` answers without starting anything (X06)."""

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


def check(files: list[str], arguments: dict[str, str], resources: Resources) -> int:
    """Print every problem of launch files, and everything they need that is missing here. Return the exit code."""
    from pyros1.launch.running.check import missing_parts, unrunnable_python  # noqa: PLC0415 - one of many queries

    problems: list[LaunchError] = []
    plan = load_plan(files, arguments, resources, problems=problems)
    texts = [*map(str, problems), *plan.warnings, *map(str, missing_parts(plan, resources.packages, resources.environ))]
    if not called_as("roslaunch-check"):
        texts += map(str, unrunnable_python(plan, resources.packages, resources.environ))
    for text in texts:
        print(text)
    if not texts:
        counts = {"file": len(plan.files), "node": len(plan.nodes), "parameter": len(plan.params)}
        print("no problems: " + ", ".join(f"{count} {what}{'s' * (count != 1)}" for what, count in counts.items()))
    return 1 if texts else 0


def answer(files: list[str], arguments: dict[str, str], resources: Resources, options: Any) -> int:
    """Print the answer to one of the queries (X06). No master is needed."""
    only_args = options.ros_args and not (options.dump_params or options.file_list)
    try:
        plan = load_plan(files, arguments, resources, only_args=only_args)
    except Error as error:
        # The parameters are unknown then, but scripts rely on exit code 0 of this query (X04).
        if not options.dump_params or options.node_args or options.find_node:
            raise
        print(f"Unable to load file {', '.join(files)}: {error}", file=sys.stderr)
        return 0
    if options.node_args:
        from pyros1.launch.reading import report  # noqa: PLC0415 - one of many queries
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
        print(_text(plan, options))
    return 0


def _text(plan: Plan, options: Any) -> str:
    if options.file_list and not options.dump_params:
        return _names(absolute_files(plan.files), options)
    if options.dump_params or options.ros_args:
        from pyros1.launch.reading import report  # noqa: PLC0415 - one of many queries

        return report.dump_params(plan) if options.dump_params else report.ros_args(plan)
    if options.graph or options.tree:
        from pyros1.launch.reading import drawing  # noqa: PLC0415 - one of many queries

        return drawing.dot(plan) if options.graph else drawing.tree(plan)
    return _names([node.full_name for node in [*plan.nodes, *plan.tests]], options)


def _names(names: list[str], options: Any) -> str:
    if not options.json:
        return "\n".join(names)
    import json  # noqa: PLC0415 - rarely needed

    return json.dumps(names, ensure_ascii=False)


class _NoNodeError(LaunchError, LookupError):
    """No node has this name."""


def _find_node(plan: Plan, name: str, files: list[str], resources: Resources) -> NodePlan:
    # Nodes may have illegal names, so the usual function for resolving does not work.
    full_name = canonicalize_name(ns_join("/" + resources.environ.get("ROS_NAMESPACE", ""), name))
    found = [node for node in [*plan.nodes, *plan.tests] if node.full_name == full_name]
    if not found:
        names = [node.full_name for node in [*plan.nodes, *plan.tests]]
        rows = "\n".join(f" * {other}" for other in names)
        raise _NoNodeError(
            f"Cannot find node named [{full_name}] in [{', '.join(files)}]{did_you_mean(full_name, names)}.\n"
            f"Node names are:\n{rows}"
        )
    if len(found) > 1:
        raise LaunchError(f"multiple nodes named [{full_name}] in [{', '.join(files)}]: give them different names")
    return found[0]
