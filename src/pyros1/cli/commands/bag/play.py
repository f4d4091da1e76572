"""``bag play``: publishes the messages in bags with their original timing (L117-L137)."""

from __future__ import annotations

import contextlib
import gc
import sys
import time
from math import inf, isfinite
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.ground.errors import MessageError
from pyros1.ground.interrupts import install_handler
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.bag.play.control import Control
    from pyros1.bag.play.player import Player, PlayOptions, Status
    from pyros1.bag.play.read_ahead import BagSet
    from pyros1.msgs import AnyMsg
    from pyros1.node import Node

_SWITCH_INTERVAL = 0.00005
"""The interpreter's switch interval in seconds. It limits how long the thread that reads bags can delay publishing."""

_COLLECTION_THRESHOLD = 100_000
"""The number of new objects after which the garbage collector runs.

The messages read ahead consist of fewer objects, so they do not trigger a collection, which can take 90 ms.
"""


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Publish the messages in bags. Return the exit code, 0."""
    paths = [*args, *(options.bags or ())]
    if not paths:
        raise UsageError("You must specify at least 1 bag file to play back.")
    _check_options(options)
    from pyros1.bag.play.control import Control  # noqa: PLC0415 - not needed for help
    from pyros1.bag.play.read_ahead import BagSet  # noqa: PLC0415
    from pyros1.node import Node  # noqa: PLC0415

    sys.setswitchinterval(_SWITCH_INTERVAL)
    with BagSet(paths, options.topics) as bags:
        _check_content(bags, options)
        gc.freeze()  # the index of a bag can be large, and is needed until the end
        gc.set_threshold(_COLLECTION_THRESHOLD)
        try:
            node = Node(f"play_{time.time_ns()}", argv=invocation.remapping_args, environ=invocation.environ)
        except SystemExit:
            return 0  # Ctrl-C while waiting for the master
        control = Control(options.pause)
        try:
            install_handler(lambda *_: control.end())
            node.on_shutdown(control.end)
            _reduce_timer_slack()
            return _play(node, bags, options, control)
        finally:
            node.shutdown()
            control.close()


def _parse_topics(option: Any, opt: str, value: Any, parser: Any) -> None:
    """Add all arguments up to the next option to the option's value."""
    topics = []
    while parser.rargs and not parser.rargs[0].startswith("-"):
        topics.append(parser.rargs.pop(0))
    setattr(parser.values, option.dest, (getattr(parser.values, option.dest) or []) + topics)


VERB = Verb(
    "play",
    "play back the contents of one or more bag files in a time-synchronized fashion",
    CHUNK_LIMIT_OPTION,
    Option("-p", "--prefix", metavar="PREFIX", default="", help="prefix all output topics"),
    Flag("-q", "--quiet", help="suppress console output"),
    Flag("-i", "--immediate", help="play back all messages without waiting"),
    Flag("--pause", help="start in paused mode"),
    Option(
        "--queue",
        type="int",
        default=100,
        metavar="SIZE",
        help="use an outgoing queue of size SIZE (defaults to %default)",
    ),
    Flag("--clock", help="publish the clock time"),
    Option(
        "--hz",
        type="float",
        default=100.0,
        metavar="HZ",
        help="use a frequency of HZ when publishing clock time (default: %default)",
    ),
    Option(
        "-d",
        "--delay",
        type="float",
        default=0.2,
        metavar="SEC",
        help="sleep SEC seconds after every advertise call (to allow subscribers to connect)",
    ),
    Option("-r", "--rate", type="float", default=1.0, metavar="FACTOR", help="multiply the publish rate by FACTOR"),
    Option("-s", "--start", type="float", default=0.0, metavar="SEC", help="start SEC seconds into the bag files"),
    Option("-u", "--duration", type="float", metavar="SEC", help="play only SEC seconds from the bag files"),
    Option(
        "--skip-empty",
        type="float",
        metavar="SEC",
        help="skip regions in the bag with no messages for more than SEC seconds",
    ),
    Flag("-l", "--loop", help="loop playback"),
    Flag("-k", "--keep-alive", help="keep alive past end of bag (useful for publishing latched topics)"),
    Flag(
        "--try-future-version",
        help="still try to open a bag file, even if the version number is not known to the player",
    ),
    Option("--topics", action="callback", callback=_parse_topics, dest="topics", help="topics to play back"),
    Option(
        "--pause-topics",
        action="callback",
        callback=_parse_topics,
        dest="pause_topics",
        help="topics to pause on during playback",
    ),
    Option("--bags", action="append", help="bag files to play back"),
    Flag("--wait-for-subscribers", help="wait for at least one subscriber on each topic before publishing"),
    Option(
        "--rate-control-topic",
        default="",
        metavar="TOPIC",
        help="watch the given topic, and if the last publish was more than <rate-control-max-delay> ago, wait until "
        "the topic publishes again to continue playback",
    ),
    Option(
        "--rate-control-max-delay",
        type="float",
        default=1.0,
        metavar="SEC",
        help="maximum time difference from <rate-control-topic> before pausing",
    ),
    Argument("BAGFILE", "bag", repeatable=True),
    usage="BAGFILE1 [BAGFILE2 BAGFILE3 ...]",
    description="Play back the contents of one or more bag files in a time-synchronized fashion.",
    examples=[
        ("run.bag", "play at the original speed; space pauses, s steps"),
        ("--clock -r 0.5 -s 60 -u 10 run.bag", "play ten seconds in slow motion, with simulated time"),
        ("run.bag --topics /scan /tf /tf_static", "play some of the topics"),
        ("a.bag b.bag /scan:=/old/scan", "play two bags together and rename one topic"),
    ],
    run=run,
)


def _reduce_timer_slack() -> None:
    """Make Linux wake this thread exactly on time. By default, Linux may wake a thread up to 50 us late."""
    with contextlib.suppress(OSError), open("/proc/self/timerslack_ns", "w", encoding="ascii") as slack_file:
        slack_file.write("1")


def _play(node: Node, bags: BagSet, options: Any, control: Control) -> int:
    from pyros1.bag.play.keyboard import Keyboard  # noqa: PLC0415
    from pyros1.bag.play.player import Player  # noqa: PLC0415
    from pyros1.cli.commands.bag._running.status import StatusLine  # noqa: PLC0415

    status_line = StatusLine(not options.quiet)

    def show_status(status: Status) -> None:
        status_line.show(
            f" [{status.state}]  Bag Time: {status.time:13.6f}   Duration: {status.elapsed:.6f} / {status.length:.6f}"
        )

    for reader in bags.readers:
        status_line.print_message(f"Opening {reader.path}")
        node.log.note(f"Opening {reader.path}")  # the only message that rosbag logs before playing
    player = Player(node, bags, _make_settings(options), control, None if options.quiet else show_status)
    for topic, reason in player.unplayable.items():
        node.log.warn("%s is not played: %s", one_line(topic), one_line(reason))
    node.advertise_service(
        "~pause_playback", "std_srvs/SetBool", lambda request: _handle_pause_request(control, request.data)
    )
    if options.rate_control_topic:
        _control_rate(node, player, options.rate_control_topic)
    player.read_ahead()
    if options.delay:
        _print_status(options, f"\nWaiting {options.delay:g} seconds after advertising topics...", end="")
        _wait_until_ended(control, options.delay)
        _print_status(options, " done.")
    if options.wait_for_subscribers and not control.end_requested:
        status_line.print_message("Waiting for subscribers.")
        player.wait_for_subscribers()
    with Keyboard(control) as keyboard:
        if keyboard.is_available:
            _print_status(options, "\nHit space to toggle paused, or 's' to step.")
        player.run()
        if not control.end_requested and options.keep_alive:
            status_line.print_message(
                "All messages were played; still running for the latched topics. Press Ctrl-C to stop."
            )
            while not control.end_requested:
                control.wait(1.0)
    status_line.clear()
    if not player.wait_until_sent():
        node.log.warn("slow subscribers did not receive all messages")
    dropped_count = player.dropped()
    if dropped_count:
        node.log.warn("%d messages were dropped because subscribers were too slow; see --queue", dropped_count)
    if not control.end_requested:
        _print_status(options, "\nDone.")
    return 0


def _print_status(options: Any, text: str, end: str = "\n") -> None:
    """Print a message unless --quiet is given. A closed output does not stop playback."""
    if not options.quiet:
        with contextlib.suppress(OSError, ValueError):
            print(text, end=end, flush=True)


def _wait_until_ended(control: Control, seconds: float) -> None:
    deadline = monotonic() + seconds
    while not control.end_requested and monotonic() < deadline:
        control.wait(deadline - monotonic())


def _handle_pause_request(control: Control, paused: bool) -> tuple[bool, str]:
    """Handle a call to the service ~pause_playback (B29). Return the values of the response: success and message."""
    new_state = "paused" if paused else "resumed"
    if control.set_paused(paused):
        return True, f"Playback is now {new_state}"
    return False, f"Bag is already {'paused' if paused else 'running'}."


def _control_rate(node: Node, player: Player, topic: str) -> None:
    """Make playback wait for a topic's header stamps (B38), or for arrival times if its messages have no header."""
    from pyros1.msgs import AnyMsg  # noqa: PLC0415
    from pyros1.observe.decoder import Decoder  # noqa: PLC0415

    decoder = Decoder()
    player.rate_stamp = 0

    def on_message(raw: AnyMsg) -> None:
        try:
            has_header = decoder.message_class(raw)._has_header
            message: Any = decoder.decode(raw) if has_header else None
        except MessageError as error:
            node.log.error("%s: %s", topic, error, throttle=5.0)
            return
        player.set_rate_stamp(message.header.stamp.to_nsec() if has_header else player.now())

    node.subscribe(topic, AnyMsg, on_message)


def _check_content(bags: BagSet, options: Any) -> None:
    """Warn about options that have no effect on these bags.

    Raises:
        CommandError: There is nothing to play.
    """
    recorded_topics = {connection.topic for reader in bags.readers for connection in reader.connections.values()}
    known_topics = set(map(_without_slash, recorded_topics))
    for topic in [*(options.topics or []), *(options.pause_topics or [])]:
        if _without_slash(topic) not in known_topics:
            print(f"WARNING: {topic} is not in the bag{did_you_mean(topic, recorded_topics)}", file=sys.stderr)
    if options.topics is not None and known_topics.isdisjoint(map(_without_slash, options.topics)):
        raise CommandError("none of the selected topics is in the bag; `pyros1 bag info` lists its topics")
    if not any(chunk.counts for reader in bags.readers for chunk in reader.chunks):
        print("WARNING: no messages to play", file=sys.stderr)
    if (
        options.clock
        and "clock" in known_topics
        and (options.topics is None or "clock" in map(_without_slash, options.topics))
    ):
        print(
            "WARNING: the bag contains /clock, and --clock publishes it too: time will jump back and forth",
            file=sys.stderr,
        )
    length = (bags.end - bags.start) / 1e9
    if options.start > length:
        raise CommandError(f"--start {options.start:g}: the bag is only {length:.3f} s long")


def _without_slash(topic: str) -> str:
    return topic.lstrip("/")


def _make_settings(options: Any) -> PlayOptions:
    from pyros1.bag.play.player import PlayOptions  # noqa: PLC0415

    return PlayOptions(
        prefix=options.prefix,
        immediate=options.immediate,
        queue_size=options.queue,
        clock_rate=options.hz if options.clock else 0.0,
        rate=options.rate,
        start=options.start,
        duration=options.duration,
        skip_empty=options.skip_empty,
        loop=options.loop,
        pause_topics=options.pause_topics or [],
        max_delay=options.rate_control_max_delay if options.rate_control_topic else inf,
    )


def _check_options(options: Any) -> None:
    for name in ("rate", "hz"):
        if not 0 < getattr(options, name) < inf:
            raise UsageError(f"--{name} must be a number greater than 0")
    for name in ("delay", "start", "duration", "skip_empty", "rate_control_max_delay"):
        value = getattr(options, name)
        if value is not None and not (isfinite(value) and value >= 0):
            raise UsageError(f"--{name.replace('_', '-')} must be a non-negative number")
    if options.queue < 0:
        raise UsageError("--queue must not be negative; 0 means no limit")
    if options.topics is not None and not options.topics:
        raise UsageError("--topics needs at least one topic")
