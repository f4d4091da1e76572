"""Explains rules, for ``pyros1 bridge --check``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pyros1.bridge.names import Pattern
from pyros1.bridge.rules.parsing import SiteConfig
from pyros1.bridge.rules.rules import DEFAULT_MAX_SIZE, LOSS_DELAY, Rule, Rules
from pyros1.bridge.rules.site_access import SiteAccess


def explain(config: SiteConfig) -> Iterator[str]:
    """Yield lines that describe what a site sends and receives.

    Args:
        config: the site's configuration.
    """
    rules = config.rules
    named = f"{'the sites' if len(rules.sites) > 1 else 'site'} {', '.join(rules.sites)}"
    partners = named if rules.sites else "all sites"
    yield f"site {rules.site}: talks to {partners}"
    yield from explain_connections(config.connect, config.listen, config.keys)
    yield from explain_access(rules.access)
    if rules.loss_delay != LOSS_DELAY:
        yield f"  considers a site lost that has not responded for {rules.loss_delay:g} s"
    yield from _explain_sent(rules)
    yield from _explain_taken(rules)
    yield from _explain_services(rules)


def explain_connections(connect: Iterable[str], listen: Iterable[str], keys: str) -> Iterator[str]:
    """Yield lines that describe where a site or router connects and listens, and its keys, if any."""
    for endpoint in connect:
        yield f"  connects to {endpoint}"
    for endpoint in listen:
        yield f"  listens on {endpoint}"
    if keys:
        yield f"  proves its name with the keys in {keys}, and requires certificates from others"


def explain_access(access: Iterable[SiteAccess]) -> Iterator[str]:
    """Yield lines that describe the permissions of other sites, unless they may do everything."""
    for each in access:
        if each.keys != each.site:
            yield f"  accepts only the keys of {each.site} that are named {each.keys}"
        for verb, allowed, denied in (
            ("send", each.send, each.deny_send),
            ("take", each.take, each.deny_take),
            ("serve", each.serve, each.deny_serve),
            ("call", each.call, each.deny_call),
        ):
            if allowed is not None or denied:
                what = "everything" if allowed is None else _join_patterns(allowed) or "nothing"
                yield f"  {each.site} may {verb} {what}" + f", but not {_join_patterns(denied)}" * bool(denied)
        if each.forwards:
            yield f"  {each.site} forwards packets from and to {', '.join(each.forwards)}"


def _join_patterns(patterns: Iterable[Pattern]) -> str:
    return ", ".join(pattern.text for pattern in patterns)


def _explain_sent(rules: Rules) -> Iterator[str]:
    yield "sends:" if rules.send else "sends nothing"
    for rule in rules.send:
        pattern, site = rule.pattern, rule.pattern.site
        if not site or site == rules.site:
            what = rule.here or pattern.path
            receivers = " and ".join(rule.sites) or "every site that takes it"
            name = f" as {rules.site}:{pattern.path}" if rule.here else ""
            yield f"  {what}{name} to {receivers}{_details(rule)}"
        else:
            prefix = _prefix_text(rules, site)
            owner = "each other site" if site == "*" else site
            yield f"  {rule.here or prefix + pattern.path} to {owner}, as {pattern.path} there{_details(rule)}"
    for denied in rules.deny_send:
        yield f"  never {denied.text}"


def _explain_taken(rules: Rules) -> Iterator[str]:
    yield "takes:" if rules.take else "takes nothing"
    for rule in rules.take:
        pattern, site = rule.pattern, rule.pattern.site
        senders = " and ".join(rule.sites)
        if not site or site == rules.site:
            yield f"  {rule.here or pattern.path}, from {senders or 'every site that sends it here'}{_details(rule)}"
        else:
            owner = senders or "each other site" if site == "*" else site
            local = rule.here or _prefix_text(rules, site) + pattern.path
            yield f"  {pattern.path} of {owner}, as {local} here{_details(rule)}"
    for denied in rules.deny_take:
        yield f"  never {denied.text}"


def _explain_services(rules: Rules) -> Iterator[str]:
    services = rules.services
    if services.serve:
        yield "lets others call:"
    for rule in services.serve:
        callers = " and ".join(rule.sites) or "every site that calls it"
        name = f" as {rules.site}:{rule.pattern.path}" if rule.here else ""
        yield f"  {rule.here or rule.pattern.path}{name}, by {callers}{_timeout(rule)}"
    for denied in services.deny_serve:
        yield f"  never {denied.text}"
    if services.call:
        yield "provides services of others:"
    for rule in services.call:
        site = rule.pattern.site
        owner = " and ".join(rule.sites) or "each other site" if site == "*" else site
        yield (
            f"  {rule.pattern.path} of {owner}, as {rule.here or _prefix_text(rules, site) + rule.pattern.path} here"
            + (_timeout(rule))
        )
    for denied in services.deny_call:
        yield f"  never {denied.text}"
    if services.params:
        yield "lets others read the parameters:"
    for pattern in services.params:
        yield f"  {pattern.path}" + (" and all below it" if pattern.is_literal else "")
    for denied in services.deny_params:
        yield f"  never {denied.text}"


def _timeout(rule: Rule) -> str:
    return "" if rule.timeout is None else f", at most {rule.timeout:g} s for a call"


def _prefix_text(rules: Rules, site: str) -> str:
    return rules.prefixes.get("*", "/SITE") if site == "*" else rules.prefix(site)


def _details(rule: Rule) -> str:
    """Return a rule's settings, such as rate, size and order, as the end of a sentence."""
    words = []
    if rule.convert is not None:
        words.append(rule.convert.words + (f" under NAME{rule.convert.suffix}" if rule.convert.suffix else ""))
    if rule.prefix_frames:
        kept = f" (but {', '.join(rule.keep_frames)})" if rule.keep_frames else ""
        words.append(f"frames as {rule.prefix_frames}/NAME{kept}")
    if rule.rate is not None:
        words.append(f"at most {rule.rate:g} messages per second")
    if rule.max_size is not None and rule.max_size != DEFAULT_MAX_SIZE:
        words.append(f"messages of at most {rule.max_size} bytes")
    if rule.age is not None:
        words.append(f"none older than {rule.age:g} s")
    if rule.reliable is not None:
        words.append("all messages in order" if rule.reliable else "only the newest if the network is slow")
    if rule.priority is not None:
        words.append(f"{rule.priority.name.lower()} priority")
    return "".join(f", {word}" for word in words)
