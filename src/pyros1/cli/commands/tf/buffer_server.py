"""``tf buffer_server``: the buffer_server of tf2_ros, which performs lookups for other nodes (L199)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb

_DEFAULT_SECONDS = 120.0


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Perform lookups for other nodes until the node is shut down."""
    if args:
        raise UsageError(f"unexpected argument {args[0]!r}")
    from pyros1.node import Node  # noqa: PLC0415 - not needed for help
    from pyros1.tf import Buffer, BufferServer, TransformListener  # noqa: PLC0415

    with Node("tf_buffer", argv=invocation.remapping_args, environ=invocation.environ) as node:
        buffer_seconds = node.params.get("~buffer_size", _DEFAULT_SECONDS)
        if (
            isinstance(buffer_seconds, bool)
            or not isinstance(buffer_seconds, (int, float))
            or not 0 < buffer_seconds < float("inf")
        ):
            raise CommandError(
                f"the parameter ~buffer_size must be a number of seconds greater than 0, not {buffer_seconds!r}"
            )
        buffer = Buffer(buffer_seconds)
        TransformListener(node, buffer)
        BufferServer(node, buffer)
        node.spin()


VERB = Verb(
    "buffer_server",
    "look up transforms for other nodes",
    usage="[_buffer_size:=SECONDS]",
    examples=[
        ("", "serve the action tf2_buffer_server"),
        ("_buffer_size:=600", "use a buffer of ten minutes"),
    ],
    stock="rosrun tf2_ros buffer_server",
    run=run,
)
