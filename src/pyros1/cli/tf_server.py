"""``pyros1 tf buffer_server``: tf2_ros' buffer_server, which answers lookups of other nodes (L199)."""

from __future__ import annotations

from pyros1.cli.common import CommandError, Invocation
from pyros1.cli.usage import Parser

_SIZE = 120.0
_EXAMPLES = {
    "%prog buffer_server": "answer on the action tf2_buffer_server",
    "%prog buffer_server _buffer_size:=600": "and remember ten minutes",
}


def main(invocation: Invocation) -> int:
    """Run the node until it is told to end; returns the exit code, 1 if ~buffer_size is not as it should be."""
    parser = Parser("rostf", "%prog buffer_server [_buffer_size:=SECONDS]", _EXAMPLES)
    _, args = parser.parse_args(invocation.args)
    if args:
        parser.error(f"no arguments are taken: {args[0]!r}")
    from pyros1.node import Node  # noqa: PLC0415 - help needs none
    from pyros1.tf import Buffer, BufferServer, TransformListener  # noqa: PLC0415

    with Node("tf_buffer", argv=invocation.remapping_args, environ=invocation.environ) as node:
        size = node.params.get("~buffer_size", _SIZE)
        if isinstance(size, bool) or not isinstance(size, (int, float)) or not 0 < size < float("inf"):
            raise CommandError(f"the parameter ~buffer_size must be a number of seconds above 0, not {size!r}")
        buffer = Buffer(size)
        TransformListener(node, buffer)
        BufferServer(node, buffer)
        node.spin()
    return 0
