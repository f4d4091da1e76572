"""rostopic, by pyros1: prints, publishes and measures topics (https://wiki.ros.org/rostopic)."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any
from urllib.parse import urlparse

import rosgraph
import roslib.message
import rospy

from pyros1.drop_in.commands import main as _main
from pyros1.drop_in.commands import run as _run
from pyros1.drop_in.module_attributes import module_getattr
from rostopic._echo import CallbackEcho, create_field_filter, msgevalgen
from rostopic._publishing import create_publisher, publish_message, stdin_publish, wait_for_subscriber
from rostopic._rates import ROSTopicBandwidth, ROSTopicDelay, ROSTopicHz

_PUBLISHING = "see publish_message, and the command `rostopic pub`"
__getattr__ = module_getattr(
    __name__,
    argv_publish=_PUBLISHING,
    create_value_transform="see create_field_filter",
    file_yaml_arg=_PUBLISHING,
    param_publish=_PUBLISHING,
    param_publish_once=_PUBLISHING,
    stdin_yaml_arg=_PUBLISHING,
)

NAME = "rostopic"
SUBSCRIBER_TIMEOUT = 5.0
_caller_apis: dict[str, str] = {}


class ROSTopicException(Exception):
    """A topic or type is unknown or invalid."""


class ROSTopicIOException(ROSTopicException):
    """The master does not respond."""


def _check_master() -> None:
    """Raise ROSTopicIOException if the master does not respond."""
    try:
        rosgraph.Master("/rostopic").getPid()
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None


def _master_get_topic_types(master: Any) -> list[list[str]]:
    types: list[list[str]] = master.getTopicTypes()
    return types


def get_api(master: Any, caller_id: str) -> str:
    """Return the address of a node's API; if the master does not know it, ``unknown address`` and the node's name.

    Raises:
        ROSTopicIOException: the master does not respond.
    """
    uri = _caller_apis.get(caller_id)
    if uri is None:
        try:
            uri = _caller_apis[caller_id] = str(master.lookupNode(caller_id))
        except rosgraph.MasterException:
            return f"unknown address {caller_id}"
        except OSError:
            raise ROSTopicIOException("Unable to communicate with master!") from None
    return uri


# Types ---------------------------------------------------------------------------------------------------------------


def _get_topic_type(topic: str) -> tuple[str | None, str | None, Callable[[Any], Any] | None]:
    try:
        topic_types = _master_get_topic_types(rosgraph.Master("/rostopic"))
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None
    matches = [
        (name, type_name)
        for name, type_name in topic_types
        if topic == name or topic.startswith((f"{name}/", f"{name}["))
    ]
    for name, type_name in sorted(matches, key=lambda pair: len(pair[0]), reverse=True):
        if type_name != rosgraph.names.ANYTYPE:
            return type_name, name, msgevalgen(topic[len(name) :])
    return None, None, None


def get_topic_type(topic: str, blocking: bool = False) -> Any:
    """Return the type and the name of a topic, and a function that extracts a field from its messages.

    Args:
        topic: full name of a topic, optionally followed by the path of a field.
        blocking: whether to wait until the topic is known.

    Returns:
        Type, topic, and a function that returns the field (None if there is no path). All are None if the topic is
        unknown.

    Raises:
        ROSTopicIOException: the master does not respond.
    """
    topic_info = _get_topic_type(topic)
    if blocking and not topic_info[0]:
        print(f"WARNING: topic [{topic}] does not appear to be published yet", file=sys.stderr)
        while not topic_info[0] and not rospy.is_shutdown():
            time.sleep(0.1)
            topic_info = _get_topic_type(topic)
    return topic_info


def get_topic_class(topic: str, blocking: bool = False) -> Any:
    """Return the same as `get_topic_type`, but with the class of the topic's messages instead of the type.

    Raises:
        ROSTopicException: there is no definition of the type.
    """
    type_name, name, field = get_topic_type(topic, blocking=blocking)
    if type_name is None:
        return None, None, None
    cls = roslib.message.get_message_class(type_name)
    if not cls:
        raise ROSTopicException(f"Cannot load message class for [{type_name}]. Are your messages built?")
    return cls, name, field


def find_by_type(topic_type: str) -> list[str]:
    """Return the names of the topics with a given type; raises ROSTopicIOException if the master does not respond."""
    try:
        topic_types = _master_get_topic_types(rosgraph.Master("/rostopic"))
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None
    return [name for name, type_name in topic_types if type_name == topic_type]


# Lists ---------------------------------------------------------------------------------------------------------------


def get_topic_list(master: Any = None) -> tuple[list[Any], list[Any]]:
    """Return publications and subscriptions, each as (topic, type, nodes); raises OSError if the master does not
    respond.
    """
    master = master or rosgraph.Master("/rostopic")
    publishers, subscribers, _ = master.getSystemState()
    types = {entry[0]: entry[1] for entry in _master_get_topic_types(master)}
    return tuple(  # type: ignore[return-value]
        [(topic, types.get(topic, "unknown type"), nodes) for topic, nodes in table]
        for table in (publishers, subscribers)
    )


def _rostopic_list_group_by_host(
    master: Any, pubs: list[Any], subs: list[Any]
) -> tuple[dict[str, list[Any]], dict[str, list[Any]]]:
    """Return the entries of `get_topic_list` by host; each entry lists only the nodes on that host."""

    def by_host(table: list[Any]) -> dict[str, list[Any]]:
        entries_by_host: dict[str, list[Any]] = {}
        for topic, type_name, nodes in table:
            nodes_by_host: dict[str, list[str]] = {}
            for node in nodes:
                nodes_by_host.setdefault(urlparse(get_api(master, node)).hostname or "unknown", []).append(node)
            for host, names in nodes_by_host.items():
                entries_by_host.setdefault(host, []).append((topic, type_name, names))
        return entries_by_host

    return by_host(pubs), by_host(subs)


def get_info_text(topic: str) -> str:
    """Return type, publishers and subscribers of a topic as text.

    Raises:
        ROSTopicException: there is no such topic.
        ROSTopicIOException: the master does not respond.
    """
    master = rosgraph.Master("/rostopic")
    try:
        publishers, subscribers = get_topic_list(master)
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None
    topic_entries = [[entry for entry in table if entry[0] == topic] for table in (publishers, subscribers)]
    if not any(topic_entries):
        raise ROSTopicException(f"Unknown topic {topic}")
    text = f"Type: {get_topic_type(topic)[0] or 'unknown type'}\n\n"
    for title, entries in zip(("Publishers", "Subscribers"), topic_entries, strict=True):
        nodes = [node for _, _, names in entries for node in names]
        rows = "".join(f" * {node} ({get_api(master, node)})\n" for node in nodes)
        text += f"{title}: " + (f"\n{rows}\n" if rows else "None\n\n")
    return text


# The tool ------------------------------------------------------------------------------------------------------------


def _run_verb(verb: str, *words: str) -> None:
    code = _run(NAME, verb, *words)
    if code:
        sys.exit(code)


def _rostopic_type(topic: str) -> None:
    _run_verb("type", topic)


def _rostopic_info(topic: str) -> None:
    _run_verb("info", topic)


def _rostopic_list(
    topic: str | None,
    verbose: bool = False,
    subscribers_only: bool = False,
    publishers_only: bool = False,
    group_by_host: bool = False,
) -> None:
    flags = {"-v": verbose, "-s": subscribers_only, "-p": publishers_only, "--host": group_by_host}
    _run_verb("list", *(flag for flag, is_set in flags.items() if is_set), *([topic] if topic else []))


def _rostopic_hz(
    topics: list[str],
    window_size: int = -1,
    filter_expr: Any = None,
    use_wtime: bool = False,
    tcp_nodelay: bool = False,
) -> None:
    if filter_expr is not None:
        raise ROSTopicException("pyros1's rostopic._rostopic_hz takes no filter: use ROSTopicHz")
    flags = ["--wall-time"] * use_wtime + ["--tcpnodelay"] * tcp_nodelay
    window = [] if window_size < 0 else ["-w", str(window_size)]
    _run_verb("hz", *window, *flags, *([topics] if isinstance(topics, str) else topics))


def _rostopic_bw(topic: str, window_size: int = -1) -> None:
    _run_verb("bw", *([] if window_size < 0 else ["-w", str(window_size)]), topic)


def _rostopic_delay(topic: str, window_size: int = -1, tcp_nodelay: bool = False) -> None:
    _run_verb("delay", *([] if window_size < 0 else ["-w", str(window_size)]), *["--tcpnodelay"] * tcp_nodelay, topic)


def _rostopic_echo(topic: str, callback_echo: Any, bag_file: str | None = None, echo_all_topics: bool = False) -> None:
    """Call a `CallbackEcho` with the messages of a topic, or of a bag, until it is done."""
    if bag_file:
        import rosbag

        with rosbag.Bag(bag_file) as bag:
            for recorded_topic, message, stamp in bag.read_messages():
                name = (
                    recorded_topic
                    if recorded_topic[:1] == "/"
                    else rosgraph.names.script_resolve_name(NAME, recorded_topic)
                )
                callback_echo.callback(message, {"topic": name, "type_information": None}, current_time=stamp)
                if callback_echo.done:
                    break
        return
    _check_master()
    rospy.init_node(NAME, anonymous=True)
    cls, real_name, field = get_topic_class(topic, blocking=True)
    if cls is None:
        return
    callback_echo.msg_eval = field
    rospy.Subscriber(real_name, cls, callback_echo.callback, {"topic": topic, "type_information": None})
    while not rospy.is_shutdown() and not callback_echo.done:
        time.sleep(0.1)


def rostopicmain(argv: list[str] | None = None) -> None:
    """Run the tool with a command line; None for the process's own."""
    _main(NAME, argv)
