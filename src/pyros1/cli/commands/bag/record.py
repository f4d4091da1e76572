"""``bag record``: records topics to bags (L90-L113)."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_marked
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.ground import names
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.bag.record.main_loop import StopSignal
    from pyros1.bag.record.model import RecordOptions
    from pyros1.bag.record.topic_selection import TopicSelection
    from pyros1.node import Node

_SIZE_UNITS = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}
_DURATION_UNITS = {"": 1, "s": 1, "m": 60, "h": 3600}


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Record topics to bags. Return 1 if an error stopped the recording, otherwise 0."""
    selection = _make_selection(options, [*args, *(options.topics or ())])
    settings = _make_settings(options)
    from pyros1.bag.record.main_loop import StopSignal  # noqa: PLC0415 - not needed for help
    from pyros1.node import Node  # noqa: PLC0415

    try:
        node = Node(f"record_{time.time_ns()}", argv=invocation.remapping_args, environ=invocation.environ)
    except SystemExit:
        return 0  # Ctrl-C while waiting for the master
    try:
        stop_signal = StopSignal(node)
        if options.snapshot:
            from pyros1.cli.commands.bag._running.snapshot import run_snapshots  # noqa: PLC0415 - rarely needed

            return run_snapshots(node, selection, settings, options, stop_signal)
        return _record(node, selection, settings, options, stop_signal)
    finally:
        node.shutdown()


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse the arguments. The deprecated ``--split=SIZE`` becomes two of them, since ``--split`` takes no value."""
    args = [part for arg in invocation.args for part in (arg.split("=", 1) if arg.startswith("--split=") else [arg])]
    return parse_marked(invocation, verb, args)


def _parse_split(option: Any, opt: str, value: Any, parser: Any) -> None:
    """Accept ``--split`` alone, or followed by a number of MB, which is deprecated (B19)."""
    parser.values.split = True
    if parser.rargs and parser.rargs[0].isdigit():
        print(
            'Use of "--split <MAX_SIZE>" has been deprecated.  '
            "Please use --split --size <MAX_SIZE> or --split --duration <MAX_DURATION>",
            file=sys.stderr,
        )
        parser.values.size = int(parser.rargs.pop(0))


VERB = Verb(
    "record",
    "record a bag file with the contents of specified topics",
    Flag("-a", "--all", help="record all topics"),
    Flag("-e", "--regex", help="match topics using regular expressions"),
    Flag("-p", "--publish", help="publish a message when the recording begins"),
    Option(
        "-x",
        "--exclude",
        metavar="EXCLUDE_REGEX",
        default="",
        help="exclude topics that match the regular expression (subtracts from -a or -e)",
    ),
    Flag("-q", "--quiet", help="suppress console output"),
    Option(
        "-o",
        "--output-prefix",
        metavar="PREFIX",
        help="begin the bag's name with PREFIX; the name ends with the date and time",
    ),
    Option("-O", "--output-name", metavar="NAME", help="record to NAME.bag"),
    Option(
        "--split",
        action="callback",
        callback=_parse_split,
        dest="split",
        default=False,
        help="start a new bag when the maximum size or duration is reached",
    ),
    Option(
        "--max-splits",
        type="int",
        default=0,
        help="keep at most MAX_SPLITS bag files: remove the oldest one when a new one begins",
    ),
    Option("--size", type="int", help="maximum size of a bag in MB (Default: infinite)"),
    Option("--duration", help="maximum duration of a bag in seconds, or in minutes or hours with 'm' or 'h' appended"),
    Option(
        "-b",
        "--buffsize",
        type="int",
        default=256,
        metavar="SIZE",
        help="use an internal buffer of SIZE MB (Default: %default, 0 = infinite)",
    ),
    Option(
        "--chunksize",
        type="int",
        default=768,
        metavar="SIZE",
        help="write chunks of SIZE KB (Default: %default)",
    ),
    Option("-l", "--limit", type="int", default=0, metavar="NUM", help="only record NUM messages on each topic"),
    Option("--node", default="", help="record all topics subscribed to by a specific node"),
    Flag("-j", "--bz2", help="use BZ2 compression"),
    Flag("--lz4", help="use LZ4 compression"),
    Flag("--tcpnodelay", help="use the TCP_NODELAY transport hint when subscribing to topics (pyros1 always does)"),
    Flag("--udp", help="use the UDP transport hint when subscribing to topics; TCP if a publisher lacks UDP"),
    Flag("--repeat-latched", help="repeat latched messages at the start of each new bag file"),
    Option(
        "-L",
        "--min-space",
        default="1G",
        metavar="SIZE",
        help="stop when less than SIZE is free on the disk (Default: %default)",
    ),
    Option("--topic", action="append", dest="topics", metavar="TOPIC", help="a topic to record"),
    Flag(
        "--snapshot",
        pyros1_only=True,
        help="write nothing, but keep the latest messages in memory; the service ~snapshot writes them to a bag",
    ),
    Option(
        "--snapshot-duration",
        type="float",
        default=30.0,
        metavar="SEC",
        pyros1_only=True,
        help="keep SEC seconds of each topic (Default: %default, 0 = all)",
    ),
    Option(
        "--snapshot-size",
        type="float",
        default=64.0,
        metavar="MB",
        pyros1_only=True,
        help="keep at most MB megabytes of each topic (Default: %default, 0 = all)",
    ),
    Argument("TOPIC", "topic", repeatable=True),
    usage="TOPIC1 [TOPIC2 TOPIC3 ...]",
    description="Record a bag file with the contents of specified topics.",
    examples=[
        ("/odom /scan -O run", "record two topics to run.bag"),
        (
            "-a -x '/camera/.*' -o day",
            "record all topics except the camera's, including topics that appear later, to day_<date>.bag",
        ),
        ("-a --lz4 --split --duration 10m --max-splits 6", "keep the last hour, in files of ten minutes"),
        (
            "-a --snapshot --snapshot-duration 60",
            "keep the last minute of messages; calling the service ~snapshot writes them to a bag",
        ),
    ],
    parse=_parse,
    run=run,
)


def _record(
    node: Node, selection: TopicSelection, settings: RecordOptions, options: Any, stop_signal: StopSignal
) -> int:
    from pyros1.bag.errors import BagError  # noqa: PLC0415
    from pyros1.bag.record.main_loop import subscribe_until_stopped, wait_for_time  # noqa: PLC0415
    from pyros1.bag.record.recorder import Events, Recorder  # noqa: PLC0415
    from pyros1.bag.record.topics import TopicSearch  # noqa: PLC0415
    from pyros1.cli.commands.bag._running.status import RecordingStatus, StatusLine, recording_summary  # noqa: PLC0415

    status_line = StatusLine(not options.quiet, log=node.log)
    announce = _make_announce_function(node) if options.publish else lambda path: None

    def on_opened(path: str) -> None:
        status_line.print_message(f"Recording to '{path}'.")
        announce(path)

    def warn(text: str) -> None:
        status_line.clear()
        node.log.warn("%s", one_line(text))

    topic_search = TopicSearch(node, selection)
    if not wait_for_time(node, stop_signal):
        return 0
    events = Events(on_opened, lambda path: status_line.print_message(f"Closing '{path}'."), warn, stop_signal.stop)
    try:
        recorder = Recorder(node, settings, events)
    except (OSError, BagError) as error:
        raise CommandError(_failure_text(error)) from None

    def subscribe(topic: str) -> None:
        if not names.is_legal_name(topic) and (options.all or options.regex or options.node):
            # Another node's invalid topic must not stop the recording.
            warn(f"'{topic}' is not a legal name and is not recorded")
            return
        status_line.print_message(f"Subscribing to {one_line(topic)}")
        recorder.subscribe(topic, transports=("udp", "tcp") if options.udp else ("tcp",))

    with recorder:
        recording_status = RecordingStatus(recorder)
        subscribe_until_stopped(
            topic_search,
            stop_signal,
            subscribe,
            lambda: status_line.show(recording_status.text()),
            recorder.unsubscribe_finished,
        )
        status_line.clear()
    if not options.quiet:
        print(recording_summary(recorder), flush=True)
    if recorder.error is not None:
        node.log.error("recording stopped: %s", _failure_text(recorder.error))
        return 1
    return 0


def _make_announce_function(node: Node) -> Callable[[str], None]:
    publisher: Any = node.advertise("begin_write", "std_msgs/String", queue_size=10, latch=True)

    def announce(path: str) -> None:
        publisher.publish(path)

    return announce


def _failure_text(error: Exception) -> str:
    if isinstance(error, OSError):
        return f"cannot write {error.filename or 'the bag'}: {error.strerror}"
    return str(error)


def _make_selection(options: Any, topics: list[str]) -> TopicSelection:
    records_all = options.all
    if options.exclude and not (records_all or options.regex or options.node or topics):
        print("only -x is given: recording all topics except those excluded", file=sys.stderr)
        records_all = True
    if not (topics or records_all or options.node):
        raise UsageError("You must specify a topic name or else use the '-a' option.")
    for name in topics:
        if not options.regex and not name.strip("/"):
            raise CommandError(f"{name!r} is not a legal topic name")
    if options.limit and (records_all or options.regex or options.node):
        raise CommandError("--limit works only with named topics, not with -a, -e, -x or --node")
    from pyros1.bag.record.topic_selection import TopicSelection  # noqa: PLC0415

    try:
        return TopicSelection(topics, options.regex, records_all, options.exclude, options.node)
    except Error as error:
        raise CommandError(str(error)) from None


def _make_settings(options: Any) -> RecordOptions:
    if options.output_prefix is not None and options.output_name is not None:
        raise UsageError("Can't set both prefix and name.")
    duration = _parse_quantity("--duration", options.duration, _DURATION_UNITS) if options.duration else 0.0
    if options.split and not options.size and not duration:
        raise UsageError("Split specified without giving a maximum duration or size")
    for name in ("size", "max_splits", "buffsize", "chunksize", "limit", "snapshot_duration", "snapshot_size"):
        if not 0 <= (getattr(options, name) or 0) < float("inf"):
            raise UsageError(f"--{name.replace('_', '-')} must be a non-negative number")
    if options.bz2 and options.lz4:
        raise UsageError("use only one of --bz2 and --lz4")
    from pyros1.bag.record.file_names import FileNames  # noqa: PLC0415
    from pyros1.bag.record.model import RecordOptions  # noqa: PLC0415

    name = options.output_name
    return RecordOptions(
        names=FileNames(name or options.output_prefix or "", has_date=name is None, has_number=options.split),
        split=options.split,
        max_size=(options.size or 0) << 20,
        max_duration=duration,
        max_splits=options.max_splits,
        buffer_size=options.buffsize << 20,
        chunk_size=options.chunksize << 10,
        compression="bz2" if options.bz2 else "lz4" if options.lz4 else "none",
        limit=options.limit,
        repeat_latched=options.repeat_latched,
        min_space=int(_parse_quantity("--min-space", options.min_space, _SIZE_UNITS)),
    )


def _parse_quantity(option: str, text: str, units: dict[str, int]) -> float:
    """Parse a number with an optional unit. Return it in the smallest unit.

    Raises:
        UsageError: the string is malformed.
    """
    number_text = text.rstrip("".join(units) + "".join(units).upper() + "B")
    unit = text[len(number_text) :].lower().removesuffix("b")
    try:
        value = float(number_text) * units[unit]
    except (ValueError, KeyError):
        value = -1.0
    if not 0 <= value < float("inf"):
        raise UsageError(
            f"{option}: {text!r} is not a number, or a number with one of the units {', '.join(filter(None, units))}"
        )
    return value
