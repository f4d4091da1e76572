"""The rosout node, which collects the log messages of all nodes (https://wiki.ros.org/rosout; L21).

It subscribes to /rosout, republishes every message on /rosout_agg, and writes it to a file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pyros1.ground import terminal_text
from pyros1.ground.log_file import LogFile
from pyros1.msgs import load_message
from pyros1.node.log.levels import LEVEL_NAMES

if TYPE_CHECKING:
    from pyros1.node.node import Node

MAX_FILE_SIZE = 100_000_000
MAX_BACKUPS = 10
_TRUE_VALUES = ("1", "true", "on", "yes")


class RosoutAggregator:
    """Collects the log messages: republishes each on /rosout_agg, and writes it to a file.

    Args:
        node: the node that subscribes and publishes, usually called ``rosout``.
        log_file: path of the file; no file is written if it is None or ROSOUT_DISABLE_FILE_LOGGING is set. The file is
            rotated at 100 MB, and ten older files are kept.
    """

    def __init__(self, node: Node, log_file: str | None) -> None:
        self._node = node
        is_disabled = node.environ.get("ROSOUT_DISABLE_FILE_LOGGING", "").lower() in _TRUE_VALUES
        self._file = None if is_disabled or log_file is None else LogFile(log_file, MAX_FILE_SIZE, MAX_BACKUPS)
        self._logs_topics = node.params.get("/rosout/omit_topics", False) is not True
        log_class = load_message("rosgraph_msgs/Log")
        self._publisher = node.advertise("/rosout_agg", log_class, queue_size=0)
        node.subscribe("/rosout", log_class, self._on_message)
        node.on_shutdown(self.close)

    def _on_message(self, message: Any) -> None:
        if self._file is not None:
            self._file.write(self._format_line(message))
        self._publisher.publish(message)

    def _format_line(self, message: Any) -> str:
        stamp = message.header.stamp
        topics = f"[topics: {', '.join(message.topics)}] " if self._logs_topics else ""
        return terminal_text.lines(
            f"{stamp.secs}.{stamp.nsecs:09d} {LEVEL_NAMES.get(message.level, message.level)} {message.name} "
            f"[{message.file}:{message.line}({message.function})] {topics}{message.msg}\n"
        )

    def close(self) -> None:
        """Close the log file."""
        if self._file is not None:
            self._file.close()
