"""``tf remap``: republishes transforms from /tf_old on /tf with renamed frames (L199)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.tf._node import open_node
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb

_MESSAGE_TYPE = "tf2_msgs/TFMessage"


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish transforms until the node is shut down."""
    if args:
        raise UsageError(f"unexpected argument {args[0]!r}: set the parameter ~mappings to the mappings")
    with open_node(invocation, "tf_remapper", is_tool=False, anonymous=False) as node:
        mappings = _parse_mappings(node.params.get("~mappings", []))
        print(f"Applying the following mappings to incoming tf frame ids {mappings}", flush=True)
        publisher: Any = node.advertise("/tf", _MESSAGE_TYPE, queue_size=100)

        def republish(message: Any) -> None:
            if not publisher.num_connections:
                return
            for transform in message.transforms:
                header = transform.header
                header.frame_id = mappings.get(header.frame_id, header.frame_id)
                transform.child_frame_id = mappings.get(transform.child_frame_id, transform.child_frame_id)
            publisher.publish(message)

        node.subscribe("/tf_old", _MESSAGE_TYPE, republish, queue_size=100)
        node.spin()


VERB = Verb(
    "remap",
    "republish /tf_old on /tf with renamed frames",
    usage="[_mappings:='[{old: NAME, new: NAME}, ...]']",
    examples=[
        ("_mappings:='[{old: base, new: robot1/base}]'", "rename one frame"),
        ("pyros1 bag play a.bag /tf:=/tf_old", "play a bag that contains the old names"),
    ],
    aliases=["tf_remap"],
    stock="tf_remap",
    run=run,
)


def _parse_mappings(value: Any) -> dict[str, str]:
    if not isinstance(value, list) or not all(isinstance(mapping, dict) for mapping in value):
        raise CommandError(f"the parameter ~mappings must be a list like [{{old: NAME, new: NAME}}], not {value!r}")
    return {str(mapping["old"]): str(mapping["new"]) for mapping in value if "old" in mapping and "new" in mapping}
