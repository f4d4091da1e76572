"""Explains the rules of a bridge in the dialect of zenoh-plugin-ros1, for ``pyros1 bridge --check``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pyros1.bridge.names import Pattern
from pyros1.bridge.plugin_ros1.config import PluginConfig
from pyros1.bridge.plugin_ros1.keys import ANY
from pyros1.bridge.rules.rules import DEFAULT_MAX_SIZE, Rule, Rules


def explain(config: PluginConfig) -> Iterator[str]:
    """Yield lines that describe what a bridge exchanges.

    Args:
        config: its configuration.
    """
    rules = config.rules
    where = "without a namespace" if rules.namespace == ANY else f"in namespace {rules.namespace}"
    age = ", older than March 2025" if rules.old_keys else ""
    yield f"talks to bridges of zenoh-plugin-ros1{age}, {where}"
    yield from (f"  connects to {endpoint}" for endpoint in config.connect)
    yield from (f"  listens on {endpoint}" for endpoint in config.listen)
    yield from _explain("sends", "to", rules.topics, rules.topics.send, rules.topics.deny_send)
    yield from _explain("takes", "from", rules.topics, rules.topics.take, rules.topics.deny_take)
    if rules.services.send:
        yield from _explain("serves", "to", rules.services, rules.services.send, rules.services.deny_send)
    if rules.services.take:
        yield from _explain("calls", "from", rules.services, rules.services.take, rules.services.deny_take)


def _explain(verb: str, way: str, rules: Rules, allowed: Iterable[Rule], denied: Iterable[Pattern]) -> Iterator[str]:
    allowed = [*allowed]
    yield f"{verb}:" if allowed else f"{verb} nothing"
    for rule in allowed:
        pattern, site = rule.pattern, rule.pattern.site or rules.site
        if site == ANY:
            others = "each namespace" if rule.pattern.site else "bridges of any namespace"
        else:
            others = f"namespace {site}"
        prefix = rules.prefixes.get("*", "/NAMESPACE") if rule.pattern.site == "*" else rules.prefix(site)
        here = rule.here or prefix + pattern.path
        there = f", as {pattern.path} there" * (here != pattern.path)
        yield f"  {here} {way} {others}{there}{_details(rule)}"
    for pattern in denied:
        yield f"  never {pattern.text}"


def _details(rule: Rule) -> str:
    words = []
    if rule.rate is not None:
        words.append(f"at most {rule.rate:g} messages per second")
    if rule.max_size is not None and rule.max_size != DEFAULT_MAX_SIZE:
        words.append(f"messages of at most {rule.max_size} bytes")
    if rule.reliable is not None:
        words.append("all messages in order" if rule.reliable else "only the newest if the network is slow")
    if rule.priority is not None:
        words.append(f"{rule.priority.name.lower()} priority")
    return "".join(f", {word}" for word in words)
