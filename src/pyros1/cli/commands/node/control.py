"""``node stop``, ``node start`` and ``node restart``: control of nodes in running launches."""

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


def _run(verb: str, past_participle: str, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Make launches stop or start nodes, and print the results."""
    if not args:
        raise UsageError("You must specify at least one node name")
    names = [invocation.resolve(arg) for arg in args]
    launches = running_launches(invocation.master)
    try:
        targets = [(launch, entry) for launch, entries in launches for entry in entries if entry.node in names]
        for launch, entry in targets:
            launch.request(verb, entry.node)
        for launch, before in targets:
            after = _wait_until_done(launch, before, verb)
            pid = f" with pid [{after.pid}]" if after.state == "running" else ""
            print(f"{before.node} {past_participle}{pid}", flush=True)
    finally:
        for launch, _ in launches:
            launch.close()
    unknown = set(names) - {entry.node for _, entry in targets}
    if unknown:
        raise CommandError("no running launch has the node " + ", ".join(sorted(unknown)))


def _make_verb(name: str, past_participle: str, about: str, example: str) -> Verb:
    return Verb(
        name,
        about,
        Argument("node", "node", many=True),
        usage="node1 [node2...]",
        examples=[("/driver", example)],
        stock="",
        run=partial(_run, name, past_participle),
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


def _wait_until_done(launch: Launch, before: Status, verb: str) -> Status:
    """Wait until the launch has carried out the request. Return the node's new status."""
    deadline = time.monotonic() + _TIMEOUT
    while time.monotonic() < deadline:
        try:
            entries = launch.status()
        except UnreachableError:
            if verb == "stop":
                return replace(before, state="stopped")
            raise CommandError(f"{before.node}: its launch has ended") from None
        after = next((entry for entry in entries if entry.label == before.label), before)
        if verb == "stop" and after.state not in ("running", "stopping"):
            return after
        if verb == "start" and after.state == "running":
            return after
        if verb == "restart" and after.starts > before.starts:
            return after
        time.sleep(_POLL_PERIOD)
    raise CommandError(f"{before.node}: the launch did not {verb} it within {_TIMEOUT:g} s")
