"""zenoh settings that let only sites with keys connect, each with its own permissions. No I/O.

zenoh identifies the sender of each incoming packet (*ingress*) and the receiver of each outgoing one (*egress*) by its
certificate, and allows or denies the packet by its key. So the names in certificates decide, not those in packets. A
connection to a site that forwards other sites' packets has its own permissions and theirs.

A key with wildcards is allowed only if all keys that it matches are allowed, but denied only if all of them are denied;
so bridges ignore packets with such keys.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from pyros1.bridge.names import Pattern
from pyros1.bridge.protocol.key_expressions import ROOT, path_key, site_key
from pyros1.bridge.rules.site_access import SiteAccess, named_sites
from pyros1.bridge.transport.certificates import SiteKeys

_EVERYTHING = f"{ROOT}/**"


def security_settings(keys: SiteKeys, access: Collection[SiteAccess], own_site: str = "") -> Mapping[str, str]:
    """Return settings for `pyros1.bridge.transport.zenoh_link.ZenohLink`.

    Args:
        keys: the keys of this site, or of this router.
        access: the permissions of the sites that connect, or that this one connects to; others may do nothing. If
            empty, all sites with keys from the same authority may do everything, and could impersonate each other.
        own_site: the name of this site; empty for a standalone router.
    """
    tls = {
        "root_ca_certificate": str(keys.ca_certificate),
        "listen_private_key": str(keys.key),
        "listen_certificate": str(keys.certificate),
        "connect_private_key": str(keys.key),
        "connect_certificate": str(keys.certificate),
        "enable_mtls": True,
        "verify_name_on_connect": True,
    }
    settings: dict[str, Any] = {f"transport/link/tls/{name}": value for name, value in tls.items()}
    if access:
        settings["access_control"] = _access_control(access, own_site)
    return {path: json.dumps(value) for path, value in settings.items()}


def _access_control(access: Collection[SiteAccess], own_site: str) -> dict[str, Any]:
    """Return zenoh's access control: deny by default, and a denying rule takes precedence."""
    sites = dict.fromkeys((*filter(None, [own_site]), *named_sites(access)))
    known = {each.site for each in access}
    # Sites whose packets others forward, and that have no entry of their own.
    everybody = [*access, *(SiteAccess(site) for site in sites if site not in known)]
    rules = [_rule("subscribe", "allow", "declare_subscriber", ("ingress", "egress"), [_EVERYTHING])]
    names: dict[str, list[str]] = {}  # a site's key name -> its rules
    for each in everybody:
        for name, permission, flow, keys in (
            (f"{each.keys} sends", "allow", "ingress", _writable_keys(each, sites)),
            (f"{each.keys} does not send", "deny", "ingress", _unwritable_keys(each, sites)),
            (f"{each.keys} takes", "allow", "egress", _readable_keys(each, sites)),
            (f"{each.keys} does not take", "deny", "egress", _unreadable_keys(each, sites)),
        ):
            if found := [*dict.fromkeys(keys)]:
                rules.append(_rule(name, permission, "put", (flow,), found))
                names.setdefault(each.keys, []).append(name)
    policies = []
    for each in access:
        if each.site == own_site:
            continue  # no other site connects with these keys
        found = ["subscribe", *names[each.keys]]
        for other in everybody:
            if other.site in each.forwards and other.site not in (own_site, each.site):
                found += names[other.keys]
        policies.append({"rules": found, "subjects": [each.keys]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [{"id": policy["subjects"][0], "cert_common_names": policy["subjects"]} for policy in policies],
        "policies": policies,
    }


def _writable_keys(access: SiteAccess, sites: Collection[str]) -> Iterator[str]:
    """Yield the keys that a site may write."""
    site = access.site
    if access.send is None or access.serve is None or access.call is None:  # if one is None, all are
        yield site_key(site, "**")
        return
    yield from (site_key(site, "hello"), site_key(site, "to/*"))
    yield from _sent_topics(access, access.send, sites)
    yield from _sent_calls(access, access.serve, access.call, sites)


def _unwritable_keys(access: SiteAccess, sites: Collection[str]) -> Iterator[str]:
    """Yield the keys that a site may not write, even if other rules allow them."""
    yield from _sent_topics(access, access.deny_send, sites)
    yield from _sent_calls(access, access.deny_serve, access.deny_call, sites)


def _sent_topics(access: SiteAccess, patterns: Iterable[Pattern], sites: Collection[str]) -> Iterator[str]:
    site = access.site
    for owner, path in _owners_and_paths(site, patterns, sites):
        yield site_key(site, f"t/{owner}{path}")
        yield site_key(site, f"again/{'*' if owner == site else owner}/{owner}{path}")


def _readable_keys(access: SiteAccess, sites: Collection[str]) -> Iterator[str]:
    """Yield the keys that a site may read."""
    site = access.site
    yield site_key("*", "hello")
    if access.take is None or access.serve is None or access.call is None:  # if one is None, all are
        yield site_key("*", f"*/{site}/**")  # packets for this site alone, or for its topics
        # Only owners' topics: messages that a site sends to another one's topic are only for that one.
        yield from (site_key(owner, f"t/{owner}/**") for owner in sites if owner != site)
        return
    yield site_key("*", f"to/{site}")
    yield from _taken_topics(access, access.take, sites)
    yield from _taken_calls(access, access.serve, access.call, sites)


def _unreadable_keys(access: SiteAccess, sites: Collection[str]) -> Iterator[str]:
    """Yield the keys that a site may not read, even if other rules allow them."""
    yield from _taken_topics(access, access.deny_take, sites)
    yield from _taken_calls(access, access.deny_serve, access.deny_call, sites)


def _taken_topics(access: SiteAccess, patterns: Iterable[Pattern], sites: Collection[str]) -> Iterator[str]:
    site = access.site
    for owner, path in _owners_and_paths(site, patterns, sites):
        sender = "*" if owner == site else owner
        yield site_key(sender, f"t/{owner}{path}")
        yield site_key(sender, f"again/{site}/{owner}{path}")


def _sent_calls(
    access: SiteAccess, serve: Iterable[Pattern], call: Iterable[Pattern], sites: Collection[str]
) -> Iterator[str]:
    """Yield the keys of replies from a site's services, and of its calls to other sites' services."""
    site = access.site
    yield from (site_key(site, f"call/*/{site}{path}") for _, path in _owners_and_paths(site, serve, sites))
    yield from (site_key(site, f"call/{owner}/{owner}{path}") for owner, path in _owners_and_paths(site, call, sites))


def _taken_calls(
    access: SiteAccess, serve: Iterable[Pattern], call: Iterable[Pattern], sites: Collection[str]
) -> Iterator[str]:
    """Yield the keys of calls to a site's services, and of replies to its calls to other sites' services."""
    site = access.site
    yield from (site_key("*", f"call/{site}/{site}{path}") for _, path in _owners_and_paths(site, serve, sites))
    yield from (site_key(owner, f"call/{site}/{owner}{path}") for owner, path in _owners_and_paths(site, call, sites))


def _owners_and_paths(site: str, patterns: Iterable[Pattern], sites: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield each site whose topics or services the patterns match, with the key expression of their names."""
    for pattern in patterns:
        owners = [each for each in sites if each != site] if pattern.site == "*" else [pattern.site or site]
        for owner in owners:
            yield owner, path_key(pattern.path)


def _rule(name: str, permission: str, message: str, flows: Collection[str], keys: Collection[str]) -> dict[str, Any]:
    return {
        "id": name,
        "permission": permission,
        "messages": [message],
        "flows": [*flows],
        "key_exprs": [*keys],
    }
