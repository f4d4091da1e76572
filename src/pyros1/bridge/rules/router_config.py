"""The configuration of a standalone router, which has neither a master nor topics of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from pyros1.bridge.rules.explanation import explain_access, explain_connections
from pyros1.bridge.rules.site_access import SiteAccess, named_sites
from pyros1.bridge.rules.sites_reader import SitesReader


@dataclass(frozen=True)
class RouterConfig:
    """A router's configuration, from command line and file.

    Attributes:
        listen: endpoints such as ``tls/[::]:7447``.
        connect: endpoints of other routers.
        keys: the folder of the router's keys; empty for none.
        access: what each site may do; empty if all may do everything.
        places: endpoint or name of a site in a file -> its file and line, for error messages.
    """

    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    keys: str = ""
    access: tuple[SiteAccess, ...] = ()
    places: Mapping[str, str] = field(default_factory=dict)


def parse_router_config(text: str, where: str) -> RouterConfig:
    """Return the configuration in a router's file.

    Args:
        text: the file's contents.
        where: its name, for errors.

    Raises:
        RulesError: the file is not valid; the message contains file and line.
        YamlError: it is not valid YAML.
    """
    return _RouterReader(text, where).read()


class _RouterReader(SitesReader):
    """Reads a router's file."""

    def read(self) -> RouterConfig:
        """Return the router's configuration."""
        file = self._mapping(self._value, (), ("listen", "to", "keys", "sites"))
        listen, connect = self._endpoints(file, "listen"), self._endpoints(file, "to")
        keys = self._text(file.get("keys", ""), ("keys",))
        return RouterConfig(listen, connect, keys, self._access(file), self.places)


def explain_router(config: RouterConfig) -> Iterator[str]:
    """Yield lines that describe a router."""
    sites = named_sites(config.access)
    yield f"a router for {', '.join(sites) or 'all sites'}"
    yield from explain_connections(config.connect, config.listen, config.keys)
    yield from explain_access(config.access)
