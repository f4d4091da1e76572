"""Reads the setting `sites` of a file: which other sites there are, and what each may do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.bridge.names import Pattern, check_site_name, site_of_keys
from pyros1.bridge.rules.file_reader import FileReader, Path, RulesError
from pyros1.bridge.rules.site_access import SiteAccess, add_names

_KEYS = ("send", "take", "deny_send", "deny_take", "forwards")


class SitesReader(FileReader):
    """Reads `sites` of a file."""

    def _access(self, file: Mapping[str, Any]) -> tuple[SiteAccess, ...]:
        """Return what each site may do. All in a list may do everything, and so may those in a mapping of whom it says
        nothing; but a site that may send something or take something may do nothing else.
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
                self._checked(item_path, site_of_keys, name)
                found = add_names(found, [name])
            return found
        return tuple(self._site_access(name, fields, (*path, name)) for name, fields in value.items())

    def _site_access(self, name: Any, value: Any, path: Path) -> SiteAccess:
        self._checked(path, site_of_keys, self._text(name, path))
        fields = self._mapping({} if value is None else value, path, _KEYS)
        is_limited = "send" in fields or "take" in fields
        return SiteAccess(
            name,
            self._patterns(fields, "send", path) if is_limited else None,
            self._patterns(fields, "take", path) if is_limited else None,
            self._patterns(fields, "deny_send", path),
            self._patterns(fields, "deny_take", path),
            tuple(
                self._checked(item_path, check_site_name, self._text(item, item_path))
                for item, item_path in self._items(fields, "forwards", path)
            ),
        )

    def _patterns(self, fields: Mapping[str, Any], key: str, path: Path) -> tuple[Pattern, ...]:
        return tuple(
            self._checked(item_path, _access_pattern, self._text(item, item_path))
            for item, item_path in self._items(fields, key, path)
        )


def _access_pattern(text: str) -> Pattern:
    if text.startswith("!"):
        raise RulesError("write topics that a site may not send or take under deny_send or deny_take, without !")
    if "@" in text:
        raise RulesError(f"{text!r:.80} has a rate, which only the rules of the sites that send and take it can have")
    return Pattern(text)
