"""The permissions that a listening site or router gives to other sites. No I/O."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

from pyros1.bridge.names import Pattern, SharedName, site_of_key_name


@dataclass(frozen=True)
class SiteAccess:
    """The permissions of the holder of certain keys.

    Attributes:
        keys: the name in their certificate: the site's name, or for later keys one such as ``red-2``.
        send, take: the topics that the site may send, and take from others; None for all. Names without a site in these
            patterns belong to the site itself.
        serve, call: the site's services that others may call, and the other sites' services that it may call; None for
            all. Requests for a site's parameters are calls to `pyros1.bridge.rules.services.PARAMETERS`.
        deny_send, deny_take, deny_serve, deny_call: exceptions to what the patterns above allow.
        forwards: other sites whose packets come through the site, since they connect to it and not here.

    Raises:
        ValueError: some but not all of `send`, `take`, `serve` and `call` are None: a site is limited in all of them or
        none.
    """

    keys: str
    send: tuple[Pattern, ...] | None = None
    take: tuple[Pattern, ...] | None = None
    serve: tuple[Pattern, ...] | None = None
    call: tuple[Pattern, ...] | None = None
    deny_send: tuple[Pattern, ...] = ()
    deny_take: tuple[Pattern, ...] = ()
    deny_serve: tuple[Pattern, ...] = ()
    deny_call: tuple[Pattern, ...] = ()
    forwards: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len({allowed is None for allowed in (self.send, self.take, self.serve, self.call)}) > 1:
            raise ValueError(f"{self.keys} is limited in some of send, take, serve and call, but not in all")

    @property
    def site(self) -> str:
        """The site to which the keys belong."""
        return site_of_key_name(self.keys)

    @property
    def is_limited(self) -> bool:
        """Whether the site's permissions are limited."""
        return self.send is not None or any((self.deny_send, self.deny_take, self.deny_serve, self.deny_call))

    def may_send(self, topic: SharedName) -> bool:
        """Return whether the site may send a topic, which may be another site's."""
        return self._matches(self.send, self.deny_send, topic)

    def may_take(self, topic: SharedName, sender: str) -> bool:
        """Return whether the site may take a topic, which is its own or the sender's."""
        return topic.site in (self.site, sender) and self._matches(self.take, self.deny_take, topic)

    def may_serve(self, service: SharedName) -> bool:
        """Return whether the site may let others call a service, which must be its own."""
        return service.site == self.site and self._matches(self.serve, self.deny_serve, service)

    def may_call(self, service: SharedName) -> bool:
        """Return whether the site may call a service, which must be another site's."""
        return service.site != self.site and self._matches(self.call, self.deny_call, service)

    def _matches(self, allowed: Iterable[Pattern] | None, denied: Iterable[Pattern], shared: SharedName) -> bool:
        return (allowed is None or any(pattern.matches(shared, self.site) for pattern in allowed)) and not any(
            pattern.matches(shared, self.site) for pattern in denied
        )


def named_sites(access: Iterable[SiteAccess]) -> tuple[str, ...]:
    """Return all named sites, including those whose packets others forward; each once, in order."""
    return tuple(dict.fromkeys(site for each in access for site in (each.site, *each.forwards)))


def may_send(access: Collection[SiteAccess], site: str, topic: SharedName) -> bool:
    """Return whether a site may send a topic, with any of its keys."""
    found = [each for each in access if each.site == site]
    return not found or any(each.may_send(topic) for each in found)


def may_take(access: Collection[SiteAccess], site: str, topic: SharedName, sender: str) -> bool:
    """Return whether a site may take a topic from another one, with any of its keys."""
    found = [each for each in access if each.site == site]
    return not found or any(each.may_take(topic, sender) for each in found)


def may_serve(access: Collection[SiteAccess], site: str, service: SharedName) -> bool:
    """Return whether a site may let others call a service of its own, with any of its keys."""
    found = [each for each in access if each.site == site]
    return not found or any(each.may_serve(service) for each in found)


def may_call(access: Collection[SiteAccess], site: str, service: SharedName) -> bool:
    """Return whether a site may call a service of another one, with any of its keys."""
    found = [each for each in access if each.site == site]
    return not found or any(each.may_call(service) for each in found)


def add_names(access: tuple[SiteAccess, ...], names: Iterable[str]) -> tuple[SiteAccess, ...]:
    """Return the permissions extended so that further key names may do everything; known names are unchanged.

    Raises:
        SiteNameError: a name cannot be a key name.
    """
    known = {each.keys for each in access}
    more = [SiteAccess(name) for name in dict.fromkeys(names) if site_of_key_name(name) and name not in known]
    return (*access, *more)
