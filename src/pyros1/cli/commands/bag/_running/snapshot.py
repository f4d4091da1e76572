"""``bag record --snapshot``: keeps the latest messages in memory until a service call writes them to a bag."""

from __future__ import annotations

from typing import Any

from pyros1.bag.errors import BagError
from pyros1.bag.record.main_loop import StopSignal, subscribe_until_stopped, wait_for_time
from pyros1.bag.record.model import RecordOptions
from pyros1.bag.record.snapshot import SnapshotBuffer
from pyros1.bag.record.topic_selection import TopicSelection
from pyros1.bag.record.topics import TopicSearch
from pyros1.cli.commands.bag._running.status import StatusLine, format_size
from pyros1.ground.terminal_text import one_line
from pyros1.node import Node


def run_snapshots(
    node: Node, selection: TopicSelection, settings: RecordOptions, options: Any, stop_signal: StopSignal
) -> int:
    """Keep messages and serve ``~snapshot`` (std_srvs/Trigger) and ``~enable`` (std_srvs/SetBool) until shutdown.

    Returns:
        The exit status, 0.
    """
    status_line = StatusLine(not options.quiet, log=node.log)
    topic_search = TopicSearch(node, selection)
    if not wait_for_time(node, stop_signal):
        return 0
    snapshots = SnapshotBuffer(
        node, settings, options.snapshot_duration, int(options.snapshot_size * (1 << 20)), node.log.warn
    )

    def on_snapshot_request(request: Any) -> tuple[bool, str]:
        try:
            path, messages = snapshots.write()
        except BagError as error:
            return False, str(error)
        except OSError as error:
            return False, f"cannot write {error.filename or 'the bag'}: {error.strerror}"
        if not path:
            return False, "no messages to write yet"
        status_line.print_message(f"Wrote {messages} messages to '{path}'.")
        return True, f"{messages} messages in {path}"

    def on_enable_request(request: Any) -> tuple[bool, str]:
        enabled = bool(request.data)
        snapshots.enable(enabled)
        status_line.print_message("Messages are being kept." if enabled else "Messages are not being kept.")
        return True, ""

    def subscribe(topic: str) -> None:
        status_line.print_message(f"Subscribing to {one_line(topic)}")
        snapshots.subscribe(topic)

    snapshot_service = node.resolve("~snapshot")
    node.advertise_service("~snapshot", "std_srvs/Trigger", on_snapshot_request)
    node.advertise_service("~enable", "std_srvs/SetBool", on_enable_request)
    status_line.print_message(
        f"Keeping the latest messages; write them to a bag with: rosservice call {snapshot_service}"
    )
    subscribe_until_stopped(
        topic_search,
        stop_signal,
        subscribe,
        lambda: status_line.show(f"{len(snapshots.topics)} topics, {format_size(snapshots.bytes)} in memory"),
    )
    status_line.clear()
    return 0
