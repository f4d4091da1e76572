"""``pyros1 tf empty_listener``: tf's tf_empty_listener: looks up and does no more, a load for measurements (L199)."""

from __future__ import annotations

from pyros1.cli.common import Invocation
from pyros1.cli.usage import Parser

_TARGET, _SOURCE = "odom_combined", "base_link"
_RATE = 10.0


def main(invocation: Invocation) -> int:
    """Run the node until it is told to end; returns the exit code."""
    parser = Parser("rostf", "%prog empty_listener", {"%prog empty_listener": f"look {_SOURCE} up in {_TARGET}"})
    _, args = parser.parse_args(invocation.args)
    if args:
        parser.error(f"no arguments are taken: {args[0]!r}")
    from pyros1.node import Node  # noqa: PLC0415 - help needs none
    from pyros1.tf import Buffer, TransformException, TransformListener  # noqa: PLC0415

    with Node("my_tf_listener", argv=invocation.remapping_args, environ=invocation.environ) as node:
        buffer = Buffer()
        TransformListener(node, buffer)
        rate = node.rate(_RATE)
        while node.ok():
            try:
                buffer.lookup_transform(_TARGET, _SOURCE)
            except TransformException as error:
                node.log.error("%s", error)
            rate.sleep()
    return 0
