"""Reads the setting `sites` from a file: the other sites and their permissions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.bridge.names import Pattern, check_site_name, site_of_key_name
from pyros1.bridge.rules.file_reader import FileReader, Path, RulesError
from pyros1.bridge.rules.service_parsing import service_pattern
from pyros1.bridge.rules.site_access import SiteAccess, add_names

_VERBS = ("send", "take", "serve", "call")
_KEYS = (*_VERBS, *(f"deny_{verb}" for verb in _VERBS), "forwards")


class SitesReader(FileReader):
    """Reads `sites` from a file."""

    def _access(self, file: Mapping[str, Any]) -> tuple[SiteAccess, ...]:
        """Return the permissions of each site. Sites in a list, and sites in a mapping without settings, may do
        everything; a site with `send`, `take`, `serve` or `call` may do nothing else.
        """
        value, path = file.get("sites"), ("sites",)
        if value is None:
            return ()
        if value in ([], {}):
            self._fail(path, "name at least one site; leave `sites` out to talk to all")
        if not isinstance(value, dict):
            found: tuple[SiteAccess, ...] = ()
            for item, item_path in self._items(file, "sites"):
                name = self._text(item, item_path)
                self._checked(item_path, site_of_key_name, name)
                found = add_names(found, [name])
                self.places.setdefault(name, self._place(item_path))
            return found
        return tuple(self._site_access(name, fields, (*path, name)) for name, fields in value.items())

    def _site_access(self, name: Any, value: Any, path: Path) -> SiteAccess:
        site = self._checked(path, site_of_key_name, self._text(name, path))
        self.places[name] = self._place(path)
        fields = self._mapping({} if value is None else value, path, _KEYS)
        allowed = {verb: self._patterns(fields, verb, path, site) for verb in _VERBS}
        denied = {f"deny_{verb}": self._patterns(fields, f"deny_{verb}", path, site) for verb in _VERBS}
        return SiteAccess(
            name,
            **(allowed if any(verb in fields for verb in _VERBS) else {}),
            **denied,
            forwards=tuple(
                self._checked(item_path, check_site_name, self._text(item, item_path))
                for item, item_path in self._items(fields, "forwards", path)
            ),
        )

    def _patterns(self, fields: Mapping[str, Any], key: str, path: Path, site: str) -> tuple[Pattern, ...]:
        verb = key.removeprefix("deny_")
        return tuple(
            self._checked(item_path, lambda text: _access_pattern(text, verb, site), self._text(item, item_path))
            for item, item_path in self._items(fields, key, path)
        )


def _access_pattern(text: str, verb: str, site: str) -> Pattern:
    """Parse a pattern of what a site may or may not do.

    Args:
        text: the pattern.
        verb: what it may do: ``send``, ``take``, ``serve`` or ``call``.
        site: the site.
    """
    if text.startswith("!"):
        raise RulesError(f"write what a site may not {verb} under deny_{verb}, without !")
    if verb in ("send", "take"):
        if "@" in text:
            raise RulesError(
                f"{text!r:.80} has a rate, which only the rules of the sites that send and take the topic can have"
            )
        return Pattern(text)
    pattern = service_pattern(text)
    is_own = pattern.site in ("", site)
    if verb == "serve" and not is_own:
        raise RulesError(f"{text!r:.80} is another site's, but {site} can serve only its own services: write /name")
    if verb == "call" and is_own:
        raise RulesError(
            f"{text!r:.80} is {site}'s own service; write whose services it may call: base:/name, base:** or *:/name"
        )
    return pattern
