"""``pyros1 tf echo``: the transform between two frames, again and again (L195, L198)."""

from __future__ import annotations

import sys
from math import degrees
from optparse import Values
from typing import TYPE_CHECKING, Any

from pyros1.cli.common import Invocation, print_json
from pyros1.cli.tf_node import Cures, await_clock, number, open_node
from pyros1.cli.usage import Parser

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.tf.buffer import Buffer

_USAGE = """Usage: tf_echo source_frame target_frame [echo_rate]

Prints where target_frame is in source_frame: the transform that takes data from target_frame into source_frame.
echo_rate is in Hz, 1 if it is not given."""

_EXAMPLES = {
    "%prog echo map base_link": "where is base_link in map? once a second",
    "%prog echo map base_link 10": "ten times a second",
    "%prog echo map base_link -l 1 -p 6": "once, with six digits",
    "%prog echo map base_link -o -0.5": "as it was half a second ago",
    "%prog echo map base_link --json": "one JSON object per line",
}


def main(invocation: Invocation) -> int:
    """Run the command; returns the exit code, 255 after wrong arguments and 1 if ``-l`` ended without any transform."""
    if not invocation.args:
        print(_USAGE)
        return 255
    options, source, target = _arguments(invocation)
    with open_node(invocation, "tf_echo") as node:
        return _echo(invocation, node, options, source, target)
    return 0


def _arguments(invocation: Invocation) -> tuple[Values, str, str]:
    parser = Parser("rostf", "%prog echo source_frame target_frame [rate] [options]", _EXAMPLES)
    parser.add_option("-r", "--rate", metavar="HZ", help="how often (1)")
    parser.add_option("-c", "--cache_time", metavar="SECONDS", default="10", help="length of the buffer (10)")
    parser.add_option("-o", "--offset", metavar="SECONDS", help="look up this long after now, before it if negative")
    parser.add_option("-t", "--time", metavar="SECONDS", help="look up at this time; default: the latest there is")
    parser.add_option("-l", "--limit", metavar="COUNT", help="end after so many lookups")
    parser.add_option("-p", "--precision", metavar="DIGITS", help="digits behind the point (3)")
    parser.add_option("--json", action="store_true", default=False, help="print a JSON object per lookup")
    parser.add_option("--tf2", action="store_true", default=False, help="print as tf2_tools echo.py does")
    options, args = parser.parse_args(invocation.args)
    if not 2 <= len(args) <= 3:
        print(_USAGE)
        raise SystemExit(255)
    rate = args[2] if len(args) == 3 else options.rate
    options.rate = 1.0 if rate is None else number(rate, "the rate", parser.error, positive=True)
    options.cache_time = number(options.cache_time, "the cache time", parser.error, positive=True)
    for name in ("offset", "time"):
        text = getattr(options, name)
        setattr(options, name, None if text is None else number(text, f"the {name}", parser.error))
    for name, what in (("limit", "the limit"), ("precision", "the precision")):
        text = getattr(options, name)
        if text is not None and not text.isdigit():
            parser.error(f"{what} must be a whole number, not {text!r}")
        setattr(options, name, None if text is None else int(text))
    return options, args[0].removeprefix("/"), args[1].removeprefix("/")


def _echo(invocation: Invocation, node: Node, options: Values, source: str, target: str) -> int:
    from pyros1.tf.buffer import Buffer  # noqa: PLC0415 - wrong arguments need none
    from pyros1.tf.errors import TransformException  # noqa: PLC0415
    from pyros1.tf.listener import TransformListener  # noqa: PLC0415

    if options.precision is None:
        options.precision = _precision(node, options)
    buffer = Buffer(options.cache_time)
    TransformListener(node, buffer)
    cures = Cures(invocation, node, buffer)
    await_clock(node)
    if buffer.can_transform(source, target, timeout=1.0) and options.offset is not None and options.time is None:
        node.sleep(min(-options.offset, options.cache_time))  # so far back there is no data yet
    rate = node.rate(options.rate)
    done = found = 0
    while node.ok() and (options.limit is None or done < options.limit):
        now = node.now().to_sec()
        when = options.time if options.time is not None else 0.0
        if options.offset is not None and options.time is None:
            when = max(0.0, now + options.offset)
        try:
            transform = buffer.lookup_transform(source, target, when)
        except TransformException as error:
            _show_failure(error, options, now, when, buffer)
            cures.tell(error, source, target)
        else:
            found += 1
            _show(transform, options, now)
        done += 1
        if done != options.limit:
            rate.sleep()
    return 0 if found or options.limit is None else 1


def _precision(node: Node, options: Values) -> int:
    """The parameter ~precision, as stock's, which says that it found it."""
    value = node.params.get("~precision", None)
    if not isinstance(value, int) or value < 0:
        return 3
    if not options.json and not options.tf2:
        print(f"Precision default value was overriden, new value: {value}")
    return value


def _show(transform: Any, options: Values, now: float) -> None:
    from pyros1.tf.quaternions import euler_from_quaternion  # noqa: PLC0415

    v, q = transform.transform.translation, transform.transform.rotation
    angles = euler_from_quaternion([q.x, q.y, q.z, q.w])
    stamp = transform.header.stamp.to_sec()
    if options.json:
        print_json(
            {
                "stamp": stamp,
                "frame_id": transform.header.frame_id,
                "child_frame_id": transform.child_frame_id,
                "translation": {"x": v.x, "y": v.y, "z": v.z},
                "rotation": {"x": q.x, "y": q.y, "z": q.z, "w": q.w},
                "rpy": dict(zip(("roll", "pitch", "yaw"), angles, strict=True)),
            }
        )
        sys.stdout.flush()
        return

    def row(*numbers: float) -> str:
        return f"[{', '.join(f'{value:.{options.precision}f}' for value in numbers)}]"

    head = f"At time {stamp}, (current time {now})" if options.tf2 else f"At time {stamp:.{options.precision}f}"
    print(
        head,
        f"- Translation: {row(v.x, v.y, v.z)}",
        f"- Rotation: in Quaternion {row(q.x, q.y, q.z, q.w)}",
        f"            in RPY (radian) {row(*angles)}",
        f"            in RPY (degree) {row(*map(degrees, angles))}",
        sep="\n",
        flush=True,
    )


def _show_failure(error: Exception, options: Values, now: float, when: float, buffer: Buffer) -> None:
    if options.json:
        print_json({"error": type(error).__name__, "text": str(error), "time": when})
        sys.stdout.flush()
    elif options.tf2:
        print(f"[ERROR] [{now:.6f}]: At time {when}, (current time {now}) {error}", file=sys.stderr, flush=True)
    else:
        print(
            f"Failure at {now:.9f}\nException thrown:{error}\nThe current list of frames is:\n"
            f"{buffer.all_frames_as_string()}",
            flush=True,
        )
