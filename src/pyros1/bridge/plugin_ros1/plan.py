"""Plans which topics and services a bridge exchanges, given the state of this master and of other bridges. No I/O.

The plan is recomputed after each change. The runner then starts what is missing and stops what is not in the plan, so
neither the order of changes nor earlier failures matter.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.plugin_ros1.keys import Kind, Resource, is_usable
from pyros1.bridge.plugin_ros1.rules import PluginRules
from pyros1.bridge.rules.rules import Settings


class LocalService(NamedTuple):
    """A service that a node of this master provides.

    Attributes:
        name: its full name.
        type, md5sum: its type; empty if it is not needed.
    """

    name: str
    type: str = ""
    md5sum: str = ""


class SentTopic(NamedTuple):
    """A topic of this master that is sent, and its transport settings."""

    local: LocalTopic
    settings: Settings


@dataclass
class TakenResource:
    """A topic or service of other bridges that is provided here: its type, its owners, and its settings."""

    type: str
    md5sum: str
    settings: Settings
    sources: list[Resource] = field(default_factory=list)


@dataclass
class Plan:
    """The topics and services that a bridge exchanges, and how.

    Attributes:
        sends: topics of this master, by the resource that other bridges see.
        takes: topics to publish here, by local name.
        serves: names of this master's services, by the resource that other bridges see.
        calls: services to provide here, by local name.
        problems: local name -> why the topic or service is not bridged.
    """

    sends: dict[Resource, SentTopic] = field(default_factory=dict)
    takes: dict[str, TakenResource] = field(default_factory=dict)
    serves: dict[Resource, str] = field(default_factory=dict)
    calls: dict[str, TakenResource] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)

    def topics_to_receive(self, subscribed: Collection[str]) -> list[Resource]:
        """Return the topics to receive.

        Args:
            subscribed: the topics published here that nodes subscribe to.
        """
        return [source for local, taken in self.takes.items() if local in subscribed for source in taken.sources]

    def announced(self, subscribed: Collection[str]) -> Iterator[Resource]:
        """Yield the topics and services to announce by beacons; argument as for `topics_to_receive`."""
        yield from self.sends
        yield from self.serves
        for source in self.topics_to_receive(subscribed):
            yield source._replace(kind=Kind.SUBSCRIBER)
        for called in self.calls.values():
            for source in called.sources:
                yield source._replace(kind=Kind.CLIENT)


def make_plan(
    rules: PluginRules, topics: Iterable[LocalTopic], services: Iterable[LocalService], heard: Collection[Resource]
) -> Plan:
    """Return the plan for the current state of this master and of other bridges.

    Args:
        rules: the bridge's rules.
        topics, services: what nodes other than bridges publish and provide on this master.
        heard: the publishers and services that other bridges announce, in the order in which they were first heard.
    """
    plan = Plan()
    known = {resource.namespace for resource in heard}
    for topic in topics:
        for namespace, name, rule in rules.sent_names(topic.name, known):
            resource = Resource(Kind.PUBLISHER, topic.type, topic.md5sum, namespace, name)
            if is_usable(resource):
                plan.sends[resource] = SentTopic(topic, rule.settings(topic.name, topic.type))
            else:
                plan.problems[topic.name] = "its type cannot be announced"
    own_services = {service.name for service in services}
    for service in services:
        for namespace, name, _ in rules.served_names(service.name, known):
            resource = Resource(Kind.SERVICE, service.type, service.md5sum, namespace, name)
            if is_usable(resource):
                plan.serves[resource] = service.name
    for resource in heard:
        found = rules.incoming(resource)
        if isinstance(found, str):
            continue
        is_service = resource.kind is Kind.SERVICE
        if is_service and found.name in own_services:
            plan.problems[found.name] = "not called elsewhere, since a node of this master provides it"
            continue
        table = plan.calls if is_service else plan.takes
        settings = found.rule.settings(found.name, resource.type)
        taken = table.setdefault(found.name, TakenResource(resource.type, resource.md5sum, settings))
        if (taken.type, taken.md5sum) == (resource.type, resource.md5sum):
            taken.sources.append(resource)
        else:
            plan.problems[found.name] = f"others of that name are ignored, since their type is not {taken.type}"
    return plan
