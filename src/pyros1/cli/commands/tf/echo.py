"""``tf echo``: prints the transform between two frames repeatedly (L195, L198)."""

from __future__ import annotations

import sys
from math import degrees
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.tf._node import LookupHints, open_node, parse_number, wait_for_clock
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation, called_as
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.printing import print_json

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.tf.buffer import Buffer

_USAGE = """Usage: {} source_frame target_frame [echo_rate]

Prints where target_frame is in source_frame: the transform that takes data from target_frame into source_frame.
echo_rate is in Hz (default 1)."""
INITIAL_TIMEOUT = 1.0
"""Maximum time in seconds to wait for transforms before the first line is printed."""


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print the transform repeatedly. Return 255 for invalid arguments, 1 if all lookups up to ``-l`` failed."""
    if not 2 <= len(args) <= 3:
        print(_USAGE.format("tf_echo" if called_as("tf_echo") else "pyros1 tf echo"))
        return 255
    _parse_options(options, args[2] if len(args) == 3 else options.rate)
    with open_node(invocation, "tf_echo") as node:
        return _print_transforms(invocation, node, options, *(name.removeprefix("/") for name in args[:2]))
    return 0


VERB = Verb(
    "echo",
    "print the transform between two frames",
    Option("-r", "--rate", metavar="HZ", help="lookups per second (1)"),
    Option("-c", "--cache_time", metavar="SECONDS", default="10", help="length of the buffer in seconds (10)"),
    Option("-o", "--offset", metavar="SECONDS", help="look up at the current time plus this many seconds"),
    Option("-t", "--time", metavar="SECONDS", help="look up at this time (default: the latest available)"),
    Option("-l", "--limit", metavar="COUNT", help="exit after this many lookups"),
    Option("-p", "--precision", metavar="DIGITS", help="digits after the decimal point (3)"),
    Flag("--json", help="print a JSON object per lookup"),
    Flag("--tf2", help="print in the format of echo.py from the package tf2_tools"),
    Argument("source_frame", "frame"),
    Argument("target_frame", "frame"),
    Argument("rate", optional=True),
    usage="source_frame target_frame [rate] [options]",
    examples=[
        ("map base_link", "print the pose of base_link in map once per second"),
        ("map base_link 10", "print the pose ten times per second"),
        ("map base_link -l 1 -p 6", "print the pose once, with six digits after the decimal point"),
        ("map base_link -o -0.5", "print the transform from half a second ago"),
        ("map base_link --json", "print one JSON object per line"),
    ],
    aliases=["tf_echo"],
    stock="rosrun tf tf_echo",
    run=run,
)


def _parse_options(options: Any, rate: str | None) -> None:
    """Convert the values of the options to numbers.

    Raises:
        UsageError: a value is not a number.
    """
    options.rate = 1.0 if rate is None else parse_number(rate, "the rate", positive=True)
    options.cache_time = parse_number(options.cache_time, "the cache time", positive=True)
    for name in ("offset", "time"):
        text = getattr(options, name)
        setattr(options, name, None if text is None else parse_number(text, f"the {name}"))
    for name, value_name in (("limit", "the limit"), ("precision", "the precision")):
        text = getattr(options, name)
        if text is not None and not text.isdigit():
            raise UsageError(f"{value_name} must be a whole number, not {text!r}")
        setattr(options, name, None if text is None else int(text))


def _print_transforms(invocation: Invocation, node: Node, options: Any, source: str, target: str) -> int:
    from pyros1.tf.buffer import Buffer  # noqa: PLC0415 - not needed for invalid arguments
    from pyros1.tf.errors import TransformException  # noqa: PLC0415
    from pyros1.tf.listener import TransformListener  # noqa: PLC0415

    if options.precision is None:
        options.precision = _read_precision(node, options)
    buffer = Buffer(options.cache_time)
    TransformListener(node, buffer)
    hints = LookupHints(invocation, node, buffer)
    wait_for_clock(node)
    if (
        buffer.can_transform(source, target, timeout=INITIAL_TIMEOUT)
        and options.offset is not None
        and options.time is None
    ):
        node.sleep(min(-options.offset, options.cache_time))  # wait until the buffer contains data of that age
    rate = node.rate(options.rate)
    lookup_count = success_count = 0
    while node.ok() and (options.limit is None or lookup_count < options.limit):
        now = node.now().to_sec()
        lookup_time = options.time if options.time is not None else 0.0
        if options.offset is not None and options.time is None:
            lookup_time = max(0.0, now + options.offset)
        try:
            transform = buffer.lookup_transform(source, target, lookup_time)
        except TransformException as error:
            _print_failure(error, options, now, lookup_time, buffer)
            hints.print_hint(error, source, target)
        else:
            success_count += 1
            _print_transform(transform, options, now)
        lookup_count += 1
        if lookup_count != options.limit:
            rate.sleep()
    return 0 if success_count or options.limit is None else 1


def _read_precision(node: Node, options: Any) -> int:
    """Return the value of the parameter ~precision (default 3). If it is set, print the stock tool's message."""
    value = node.params.get("~precision", None)
    if not isinstance(value, int) or value < 0:
        return 3
    if not options.json and not options.tf2:
        print(f"Precision default value was overriden, new value: {value}")
    return value


def _print_transform(transform: Any, options: Any, now: float) -> None:
    from pyros1.tf.rotation import to_angles  # noqa: PLC0415

    translation, rotation = transform.transform.translation, transform.transform.rotation
    angles = to_angles((rotation.x, rotation.y, rotation.z, rotation.w))
    stamp = transform.header.stamp.to_sec()
    if options.json:
        print_json(
            {
                "stamp": stamp,
                "frame_id": transform.header.frame_id,
                "child_frame_id": transform.child_frame_id,
                "translation": {"x": translation.x, "y": translation.y, "z": translation.z},
                "rotation": {"x": rotation.x, "y": rotation.y, "z": rotation.z, "w": rotation.w},
                "rpy": dict(zip(("roll", "pitch", "yaw"), angles, strict=True)),
            }
        )
        sys.stdout.flush()
        return

    def format_vector(*numbers: float) -> str:
        return f"[{', '.join(f'{value:.{options.precision}f}' for value in numbers)}]"

    heading = f"At time {stamp}, (current time {now})" if options.tf2 else f"At time {stamp:.{options.precision}f}"
    print(
        heading,
        f"- Translation: {format_vector(translation.x, translation.y, translation.z)}",
        f"- Rotation: in Quaternion {format_vector(rotation.x, rotation.y, rotation.z, rotation.w)}",
        f"            in RPY (radian) {format_vector(*angles)}",
        f"            in RPY (degree) {format_vector(*map(degrees, angles))}",
        sep="\n",
        flush=True,
    )


def _print_failure(error: Exception, options: Any, now: float, lookup_time: float, buffer: Buffer) -> None:
    if options.json:
        print_json({"error": type(error).__name__, "text": str(error), "time": lookup_time})
        sys.stdout.flush()
    elif options.tf2:
        print(f"[ERROR] [{now:.6f}]: At time {lookup_time}, (current time {now}) {error}", file=sys.stderr, flush=True)
    else:
        print(
            f"Failure at {now:.9f}\nException thrown:{error}\nThe current list of frames is:\n"
            f"{buffer.all_frames_as_string()}",
            flush=True,
        )
