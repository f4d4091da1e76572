"""``pyros1 bridge``: connects the masters of several sites. Stock ROS has no such command."""

from __future__ import annotations

from pyros1.cli import registry
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command
from pyros1.cli.running import print_unknown_verb, run_verb, verb_list


def _dispatch(invocation: Invocation) -> int | None:
    """Run the verb that the first argument names; without a verb, run the bridge. Return the exit code."""
    argv = invocation.argv
    first = argv[0] if argv else ""
    verb = registry.find_verb("bridge", first)
    if verb is None and first in ("", "-h", "--help", "help"):
        print(verb_list(COMMAND, invocation.program, as_stock=False))
        return 0 if first else COMMAND.usage_exit_code
    if verb is None and not first.startswith("-") and ":=" not in first:  # not an option or a remapping
        return print_unknown_verb(COMMAND, Invocation("bridge", "", argv, environ=invocation.environ))
    words = argv if verb is not None else ["run", *argv]
    record = registry.load_verb("bridge", verb or "run")
    return run_verb(record, Invocation("bridge", "", words, environ=invocation.environ))


COMMAND = Command(
    "bridge",
    "exchange topics with other masters, over networks that may break",
    group="run",
    heading="usage: {program} [run] --site NAME [options]\n       {program} <command> [arguments]\n\nCommands:",
    order=("run", "status", "param", "ros2", "keys", "router"),
    dispatch=_dispatch,
)
