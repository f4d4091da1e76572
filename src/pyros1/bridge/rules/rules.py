"""The rules of a site: what it sends and receives, with names, rates, sizes, priorities and maximum ages.

Nothing is sent or received without a rule that allows it. A denying rule overrides all allowing ones; among the
allowing ones, the first match sets the settings. Settings that a rule leaves open depend on the message type.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import NamedTuple

from pyros1.bridge.conversions.conversion import Conversion
from pyros1.bridge.names import Pattern, SharedName, is_topic_name
from pyros1.bridge.rules.site_access import SiteAccess, may_send, may_take

DEFAULT_MAX_SIZE = 16 << 20
"""Maximum size of a message in bytes, unless the rule sets another one."""
NEWEST_AGE = 2.0
"""Maximum age of a message in seconds where only the newest one counts, unless the rule or type sets another one."""
RELIABLE_AGE = 30.0
"""Maximum age of a message in seconds where every message counts."""
LOSS_DELAY = 5.0
"""Seconds without a response after which another site, or a local node whose topics it wants, counts as lost."""


class Priority(IntEnum):
    """The priority of messages if the network is slow: those with lower numbers are sent first."""

    URGENT = 0
    HIGH = 1
    NORMAL = 2
    LOW = 3
    BACKGROUND = 4


class Settings(NamedTuple):
    """The transport settings of a topic.

    Attributes:
        local: the topic's name on this site's master.
        rate: maximum messages per second of each publisher; None for no limit.
        max_size: maximum size of a message in bytes.
        priority: the priority of its messages.
        reliable: whether all messages are delivered in order, as long as they are not too old; otherwise a newer
            message replaces a waiting one.
        age: maximum age of a message in seconds when it is delivered. Latched messages have no limit, since they
            describe a state that is still valid.
        may_latch: whether a message may be latched for other sites.
        prefix_frames, keep_frames: see `Rule`.
    """

    local: str
    rate: float | None
    max_size: int
    priority: Priority
    reliable: bool
    age: float
    may_latch: bool = True
    prefix_frames: str = ""
    keep_frames: tuple[str, ...] = ()


class _TypeDefaults(NamedTuple):
    priority: Priority = Priority.NORMAL
    reliable: bool = False
    age: float | None = None


_COMMAND = _TypeDefaults(Priority.URGENT, age=0.5)
_LARGE = _TypeDefaults(Priority.LOW)
_EVENT = _TypeDefaults(Priority.HIGH, reliable=True)
_BY_TYPE: Mapping[str, _TypeDefaults] = {
    "geometry_msgs/Twist": _COMMAND,
    "geometry_msgs/TwistStamped": _COMMAND,
    "ackermann_msgs/AckermannDrive": _COMMAND,
    "ackermann_msgs/AckermannDriveStamped": _COMMAND,
    "sensor_msgs/Joy": _COMMAND,
    "sensor_msgs/Image": _LARGE,
    "sensor_msgs/CompressedImage": _LARGE,
    # A video frame depends on earlier ones.
    "foxglove_msgs/CompressedVideo": _TypeDefaults(Priority.LOW, reliable=True, age=NEWEST_AGE),
    "sensor_msgs/PointCloud": _LARGE,
    "sensor_msgs/PointCloud2": _LARGE,
    "actionlib_msgs/GoalID": _EVENT,
    # Each message has only some of the frames, so it does not replace earlier ones.
    "tf2_msgs/TFMessage": _TypeDefaults(reliable=True, age=NEWEST_AGE),
    "tf/tfMessage": _TypeDefaults(reliable=True, age=NEWEST_AGE),
    "rosgraph_msgs/Log": _TypeDefaults(Priority.LOW, reliable=True),
}
_GOAL_SUFFIX = "ActionGoal"
_EVENT_SUFFIXES = (_GOAL_SUFFIX, "ActionResult")


def _is_command(type_name: str) -> bool:
    """Return whether messages of a type are commands to a robot. They are never latched for other sites: ``rostopic
    pub`` latches its message, and a command from before an outage must not be carried out afterwards.
    """
    is_goal_or_cancel = type_name.endswith(_GOAL_SUFFIX) or type_name == "actionlib_msgs/GoalID"
    return is_goal_or_cancel or _BY_TYPE.get(type_name) is _COMMAND


@dataclass(frozen=True)
class Rule:
    """A rule that allows topics to be sent or received. If an attribute is None, the message type decides.

    Attributes:
        pattern: the topics.
        here: their names on this site's master: a name for a pattern without wildcards, ``/name/**`` for one that ends
            in ``/**``; empty for the usual names.
        sites: the sites to which topics are sent, or from which they are taken; empty for all.
        rate, max_size, priority, reliable: see `Settings`.
        age: see `Settings`; a topic with a maximum age is never latched for other sites.
        timeout: for services: maximum seconds that a call may take.
        convert: how messages are converted before they are sent. The rule applies only to types that can be converted
            so.
        prefix_frames: a prefix such as ``red`` for the coordinate frames in received messages (``red/base_link``);
            empty for none.
        keep_frames: the frames that keep their names.
    """

    pattern: Pattern
    here: str = ""
    sites: tuple[str, ...] = ()
    rate: float | None = None
    max_size: int | None = None
    priority: Priority | None = None
    reliable: bool | None = None
    age: float | None = None
    timeout: float | None = None
    convert: Conversion | None = None
    prefix_frames: str = ""
    keep_frames: tuple[str, ...] = ()

    def applies_to(self, site: str) -> bool:
        """Return whether the rule applies to another site."""
        return not self.sites or site in self.sites

    def settings(self, local: str, type_name: str) -> Settings:
        """Return the settings of a topic that the rule allows.

        Args:
            local: the topic's name on this site's master.
            type_name: its message type.
        """
        defaults = _EVENT if type_name.endswith(_EVENT_SUFFIXES) else _BY_TYPE.get(type_name, _TypeDefaults())
        reliable = defaults.reliable if self.reliable is None else self.reliable
        age = defaults.age if defaults.age is not None else RELIABLE_AGE if reliable else NEWEST_AGE
        return Settings(
            local,
            self.rate,
            DEFAULT_MAX_SIZE if self.max_size is None else self.max_size,
            defaults.priority if self.priority is None else self.priority,
            reliable,
            age if self.age is None else self.age,
            self.age is None and not _is_command(type_name),
            self.prefix_frames,
            self.keep_frames,
        )


class RuleMatch(NamedTuple):
    """A topic that may be sent: its name between sites, and its rule."""

    shared: SharedName
    rule: Rule


@dataclass(frozen=True)
class ServiceRules:
    """A site's rules about services and parameters.

    Attributes:
        serve, call: which of this site's services others may call, and which of other sites' services are provided
            here.
        deny_serve, deny_call: exceptions to these.
        params, deny_params: which parameters others may read, including everything below them, and exceptions.
    """

    serve: tuple[Rule, ...] = ()
    call: tuple[Rule, ...] = ()
    deny_serve: tuple[Pattern, ...] = ()
    deny_call: tuple[Pattern, ...] = ()
    params: tuple[Pattern, ...] = ()
    deny_params: tuple[Pattern, ...] = ()


@dataclass(frozen=True)
class Rules:
    """All rules of a site.

    Attributes:
        site: the site's name.
        send, take: the topics that are allowed, in order.
        deny_send, deny_take: the topics that are denied.
        prefixes: the namespace for each other site's topics on this site's master, by site, and ``*`` for all others;
            by default ``/SITE``. An empty string is the root.
        sites: the sites to talk to; empty for all.
        access: what other sites may do if this site listens.
        services: the rules about services and parameters, see `pyros1.bridge.rules.services`.
        loss_delay: seconds without a response after which another site, or a local node whose topics another site
            wants, is lost.
    """

    site: str
    send: tuple[Rule, ...] = ()
    take: tuple[Rule, ...] = ()
    deny_send: tuple[Pattern, ...] = ()
    deny_take: tuple[Pattern, ...] = ()
    prefixes: Mapping[str, str] = field(default_factory=dict)
    sites: tuple[str, ...] = ()
    access: tuple[SiteAccess, ...] = ()
    services: ServiceRules = ServiceRules()
    loss_delay: float = LOSS_DELAY

    def talks_to(self, site: str) -> bool:
        """Return whether this site talks to another one."""
        return site != self.site and (not self.sites or site in self.sites)

    def prefix(self, site: str) -> str:
        """Return the namespace in which another site's topics appear here; empty for the root."""
        if site == self.site:
            return ""
        return self.prefixes.get(site, self.prefixes.get("*", f"/{site}"))

    def default_name(self, shared: SharedName) -> str:
        """Return a topic's name on this site's master, unless its rule sets another one."""
        return self.prefix(shared.site) + shared.name

    def outgoing(
        self, local: str, others: Iterable[str], possible: Collection[Conversion] | None = None
    ) -> list[RuleMatch]:
        """Return the names under which a topic of this site's master may be sent; usually none or one.

        Args:
            local: the topic's name on this site's master.
            others: the known other sites.
            possible: the possible conversions of its type; None if unknown.
        """
        found: dict[SharedName, Rule] = {}
        known = [*others]
        for rule in self.send:
            if rule.convert is not None and possible is not None and rule.convert not in possible:
                continue
            for original in self._shared_names(rule, local, known):
                shared = original
                if rule.convert is not None:
                    shared = original._replace(name=original.name + rule.convert.suffix)
                is_denied = self._is_denied(self.deny_send, original) or self._is_denied(self.deny_send, shared)
                if is_topic_name(shared.name) and not is_denied:
                    found.setdefault(shared, rule)
        return [RuleMatch(shared, rule) for shared, rule in found.items()]

    def names(self, rule: Rule, local: str) -> bool:
        """Return whether a send rule names a topic of this site's master, without wildcards."""
        return rule.pattern.is_literal and any(self._shared_names(rule, local, [*self.sites]))

    def _shared_names(self, rule: Rule, local: str, others: list[str]) -> Iterator[SharedName]:
        pattern = rule.pattern
        owners = others if pattern.site == "*" else [pattern.site or self.site]
        for owner in owners:
            name = remote_name(rule, local, self.prefix(owner))
            if name is not None and pattern.matches_name(name):
                yield SharedName(owner, name)

    def receivers(self, outgoing: RuleMatch, others: Iterable[str]) -> list[str]:
        """Return the sites to which a topic may be sent; a topic that another site owns is sent only to that site."""
        own = outgoing.shared.site == self.site
        return [
            site
            for site in others
            if self.talks_to(site)
            and (own or site == outgoing.shared.site)
            and outgoing.rule.applies_to(site)
            and may_take(self.access, site, outgoing.shared, self.site)
        ]

    def incoming(self, shared: SharedName, sender: str) -> Rule | str:
        """Return the rule that accepts a topic from a site, or the reason why it is refused.

        Args:
            shared: the topic's name between sites.
            sender: the site that offers it.
        """
        if shared.site not in (sender, self.site):
            return f"{sender} offers a topic of another site"
        if self._is_denied(self.deny_take, shared):
            return "denied by a rule"
        if not may_send(self.access, sender, shared):
            return f"{sender} may not send it"
        for rule in self.take:
            if rule.pattern.matches(shared, self.site) and rule.applies_to(sender):
                return rule
        return "no rule takes it"

    def local_name(self, rule: Rule, shared: SharedName) -> str:
        """Return the local name of a topic that a rule accepts."""
        if not rule.here:
            return self.default_name(shared)
        subtree = rule.pattern.subtree
        return rule.here if subtree is None else rule.here.removesuffix("/**") + shared.name[len(subtree) :]

    def _is_denied(self, patterns: Iterable[Pattern], shared: SharedName) -> bool:
        return any(pattern.matches(shared, self.site) for pattern in patterns)


def remote_name(rule: Rule, local: str, prefix: str) -> str | None:
    """Return a topic's name on the master of the site that owns it; None if the rule does not apply to it."""
    if not rule.here:
        return local[len(prefix) :] if local.startswith(prefix + "/") else None
    subtree = rule.pattern.subtree
    if subtree is None:
        return rule.pattern.path if local == rule.here else None
    here = rule.here.removesuffix("/**")
    return subtree + local[len(here) :] if local.startswith(here + "/") else None
