"""``node stop``, ``node start`` and ``node restart``: control the nodes of running launches."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.ground.errors import UnreachableError
from pyros1.launch.running.control import Launch, Status, running_launches

_POLL_PERIOD = 0.05
_TIMEOUT = 30.0


def _control_nodes(verb: str, past_participle: str, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Make launches stop, start or restart nodes, and print the results."""
    if not args:
        raise UsageError("You must specify at least one node name")
    names = [invocation.resolve(arg) for arg in args]
    launches = running_launches(invocation.master)
    try:
        selected_entries = [(launch, entry) for launch, entries in launches for entry in entries if entry.node in names]
        for launch, entry in selected_entries:
            launch.request(verb, entry.node)
        for launch, old_status in selected_entries:
            new_status = _wait_until_done(launch, old_status, verb)
            pid = f" with pid [{new_status.pid}]" if new_status.state == "running" else ""
            print(f"{old_status.node} {past_participle}{pid}", flush=True)
    finally:
        for launch, _ in launches:
            launch.close()
    unknown_names = set(names) - {entry.node for _, entry in selected_entries}
    if unknown_names:
        raise CommandError("no running launch has the node " + ", ".join(sorted(unknown_names)))


def _make_verb(name: str, past_participle: str, about: str, example: str) -> Verb:
    return Verb(
        name,
        about,
        Argument("node", "node", repeatable=True),
        usage="node1 [node2...]",
        examples=[("/driver", example)],
        stock="",
        run=partial(_control_nodes, name, past_participle),
    )


VERBS = [
    _make_verb("stop", "stopped", "stop a node of a launch", "stop a node; the launch does not start it again"),
    _make_verb("start", "started", "start a stopped node of a launch", "start a node that was stopped or has exited"),
    _make_verb(
        "restart",
        "restarted",
        "stop a node of a launch and start it again",
        "restart a node, for example after its program has changed",
    ),
]


def _wait_until_done(launch: Launch, old_status: Status, verb: str) -> Status:
    """Wait until the launch has carried out the request. Return the node's new status."""
    deadline = time.monotonic() + _TIMEOUT
    while time.monotonic() < deadline:
        try:
            entries = launch.status()
        except UnreachableError:
            if verb == "stop":
                return replace(old_status, state="stopped")
            raise CommandError(f"{old_status.node}: its launch has ended") from None
        new_status = next((entry for entry in entries if entry.label == old_status.label), old_status)
        if verb == "stop" and new_status.state not in ("running", "stopping"):
            return new_status
        if verb == "start" and new_status.state == "running":
            return new_status
        if verb == "restart" and new_status.starts > old_status.starts:
            return new_status
        time.sleep(_POLL_PERIOD)
    raise CommandError(f"{old_status.node}: the launch did not {verb} it within {_TIMEOUT:g} s")
