"""Rules for the topics and services that a bridge to ROS 2 may exchange. No I/O."""

from __future__ import annotations

from collections.abc import Iterable

from pyros1.bridge.local_graph import STAND_IN_SERVICE
from pyros1.bridge.names import Pattern, SiteNameError
from pyros1.bridge.parameters import PARAMETER_SERVICE
from pyros1.doctor.bridge_status import STATUS_SERVICE
from pyros1.ground.errors import Error

LOG = "/rosout"
"""The topic of the log. ROS 1 sees ROS 2's log, but ROS 2 sees ROS 1's only if a rule names it."""
NEVER = ("/rosout_agg", "/parameter_events", "/statistics")
"""Topics that are never exchanged, since each side has its own."""
NEVER_SERVICES = (
    "get_loggers",
    "set_logger_level",
    "tf2_frames",
    STATUS_SERVICE,
    STAND_IN_SERVICE,
    PARAMETER_SERVICE,
    "describe_parameters",
    "get_parameters",
    "get_parameter_types",
    "list_parameters",
    "set_parameters",
    "set_parameters_atomically",
    "get_type_description",
    "get_logger_levels",
    "set_logger_levels",
)
"""The last parts of the names of services that are never exchanged, since every node provides its own."""
_MAX_REMEMBERED = 20_000
"""Maximum number of names whose matches are cached."""
ACTION_TOPICS = ("goal", "cancel", "status", "feedback", "result")
"""The last parts of the names of a ROS 1 action's topics."""
_ACTION = "/_action/"
"""Part of the name of each service of a ROS 2 action."""


_READ = "get_parameters"


class Ros2RulesError(Error, ValueError):
    """A pattern is not valid."""


class Ros2Rules:
    """The rules of a bridge to ROS 2.

    Args:
        send: patterns of the ROS 1 topics and services that ROS 2 may see, such as ``/odom`` or ``/camera/**``;
            ``!/secret`` excludes.
        take: the same for ROS 2 topics and services that ROS 1 may see. If both are empty, everything is exchanged.
        reconfigure: patterns of the ROS 2 nodes presented as dynamic_reconfigure servers in ROS 1; each needs two
            topics and a service there, so there are none by default.

    Raises:
        Ros2RulesError: a pattern is not valid.
    """

    def __init__(self, send: Iterable[str] = (), take: Iterable[str] = (), reconfigure: Iterable[str] = ()) -> None:
        send, take = [*send], [*take]
        if not any(not word.startswith("!") for word in (*send, *take)):
            send, take = ["/**", *send], ["/**", *take]
        self._send = _Names(send)
        self._take = _Names(take)
        self._reconfigure = _Names([*reconfigure])

    def sends(self, topic: str) -> bool:
        """Return whether ROS 2 may see a ROS 1 topic."""
        if topic == LOG and not self._send.names(LOG):
            return False
        return topic not in NEVER and self._send.includes(topic)

    def needs_type(self, topic: str) -> bool:
        """Return whether a ROS 1 topic's type must be known: ROS 2 may see the topic, or the action it belongs to."""
        name, _, last = topic.rpartition("/")
        return self.sends(topic) or (last in ACTION_TOPICS and self._send.includes(name))

    def takes(self, topic: str) -> bool:
        """Return whether ROS 1 may see a ROS 2 topic."""
        return topic not in NEVER and self._take.includes(topic)

    def serves(self, service: str) -> bool:
        """Return whether ROS 2 may call a ROS 1 service."""
        return not _is_internal(service) and self._send.includes(service)

    def calls(self, service: str) -> bool:
        """Return whether ROS 1 may call a ROS 2 service."""
        return not _is_internal(service) and self._take.includes(service)

    def reconfigures(self, node: str) -> bool:
        """Return whether dynamic_reconfigure's tools may see and set the parameters of a ROS 2 node."""
        return self._reconfigure.includes(node)

    def reads(self, node: str) -> bool:
        """Return whether ROS 1 may read the parameters of a ROS 2 node: if it may set them, or call its services."""
        return self.reconfigures(node) or self._take.includes(f"{node}/{_READ}")

    def explain(self) -> list[str]:
        """Return lines that describe what is exchanged."""
        return [
            f"from ROS 1 to ROS 2: {self._send}",
            f"from ROS 2 to ROS 1: {self._take}",
            f"parameters of ROS 2 nodes for dynamic_reconfigure: {self._reconfigure}",
            f"the log ({LOG}): {self._explain_log()}",
            f"never exchanged, topics: {', '.join(NEVER)}",
            f"never exchanged, services: {', '.join('*/' + name for name in NEVER_SERVICES)}",
        ]

    def _explain_log(self) -> str:
        ways = ["from ROS 2 to ROS 1"] * self.takes(LOG) + ["from ROS 1 to ROS 2"] * self.sends(LOG)
        return " and ".join(ways) or "not exchanged"


def _is_internal(service: str) -> bool:
    return service.rpartition("/")[2] in NEVER_SERVICES or _ACTION in service


class _Names:
    def __init__(self, words: list[str]) -> None:
        self._allowed = [_pattern(word) for word in words if not word.startswith("!")]
        self._denied = [_pattern(word[1:]) for word in words if word.startswith("!")]
        self._included: dict[str, bool] = {}  # the same names are looked up again and again

    def includes(self, name: str) -> bool:
        found = self._included.get(name)
        if found is None:
            found = any(each.matches_name(name) for each in self._allowed) and not any(
                each.matches_name(name) for each in self._denied
            )
            if len(self._included) >= _MAX_REMEMBERED:
                self._included = {}  # a new one, since other threads may read the old one
            self._included[name] = found
        return found

    def names(self, name: str) -> bool:
        """Return whether a name is listed literally, and not only matched by a pattern."""
        return any(each.text == name for each in self._allowed)

    def __str__(self) -> str:
        allowed = ", ".join(each.text for each in self._allowed) or "nothing"
        return allowed + "".join(f", but not {each.text}" for each in self._denied)


def _pattern(word: str) -> Pattern:
    try:
        pattern = Pattern(word)
    except SiteNameError:
        pattern = None
    if pattern is None or pattern.site:
        raise Ros2RulesError(f"{word!r:.80} is not a pattern of topics, services or nodes: write /odom or /camera/**")
    return pattern
