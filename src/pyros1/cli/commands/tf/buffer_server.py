"""``tf buffer_server``: the buffer_server of tf2_ros, which performs lookups for other nodes (L199)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb

_DEFAULT_SIZE = 120.0


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Run the node until it is shut down."""
    if args:
        raise UsageError(f"unexpected argument {args[0]!r}")
    from pyros1.node import Node  # noqa: PLC0415 - not needed for help
    from pyros1.tf import Buffer, BufferServer, TransformListener  # noqa: PLC0415

    with Node("tf_buffer", argv=invocation.remapping_args, environ=invocation.environ) as node:
        size = node.params.get("~buffer_size", _DEFAULT_SIZE)
        if isinstance(size, bool) or not isinstance(size, (int, float)) or not 0 < size < float("inf"):
            raise CommandError(f"the parameter ~buffer_size must be a number of seconds greater than 0, not {size!r}")
        buffer = Buffer(size)
        TransformListener(node, buffer)
        BufferServer(node, buffer)
        node.spin()


VERB = Verb(
    "buffer_server",
    "serve lookups of transforms to other nodes",
    usage="[_buffer_size:=SECONDS]",
    examples=[
        ("", "serve the action tf2_buffer_server"),
        ("_buffer_size:=600", "use a buffer of ten minutes"),
    ],
    stock="rosrun tf2_ros buffer_server",
    run=run,
)
