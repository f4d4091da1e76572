"""Settings of zenoh with which only sites with keys connect, and each writes only under its own name. No I/O."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from typing import Any

from pyros1.bridge.protocol.key_expressions import ROOT, site_key
from pyros1.bridge.transport.certificates import SiteKeys

_EVERYTHING = f"{ROOT}/**"


def security_settings(keys: SiteKeys, sites: Collection[str]) -> Mapping[str, str]:
    """Return settings for `pyros1.bridge.transport.zenoh_link.ZenohLink`.

    Args:
        keys: the keys of this site.
        sites: the sites that may exchange packets with this one, all of which connect to it. If there are none, all
            sites with keys of the same authority may, and they could impersonate each other.
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
    if sites:
        settings["access_control"] = _access_control(sorted({*sites} - {keys.site}))
    return {path: json.dumps(value) for path, value in settings.items()}


def _access_control(sites: Collection[str]) -> dict[str, Any]:
    """Return zenoh's access control for the connections of other sites, which are recognised by their certificates.

    What a site sends arrives here as *ingress*; what others send to it leaves as *egress*. It gets the messages of all
    topics, but of other packets only those for it or for all.
    """
    rules = [_rule("subscribe", ("declare_subscriber",), ("ingress", "egress"), (_EVERYTHING,))]
    policies = []
    for site in sites:
        written, read = f"written by {site}", f"read by {site}"
        rules.append(_rule(written, ("put",), ("ingress",), (site_key(site, "**"),)))
        readable = ("hello", f"to/{site}", "t/**", f"again/{site}/**")
        rules.append(_rule(read, ("put",), ("egress",), [site_key("*", key) for key in readable]))
        policies.append({"rules": ["subscribe", written, read], "subjects": [site]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [{"id": site, "cert_common_names": [site]} for site in sites],
        "policies": policies,
    }


def _rule(name: str, messages: Collection[str], flows: Collection[str], keys: Collection[str]) -> dict[str, Any]:
    return {
        "id": name,
        "permission": "allow",
        "messages": [*messages],
        "flows": [*flows],
        "key_exprs": [*keys],
    }
