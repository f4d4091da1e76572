"""Definitions of message types that other sites use. Each site is asked for the definitions of its own topics, by md5
sum, so that no site can block another one's topics by withholding a definition. No I/O.
"""

from __future__ import annotations

from collections.abc import Iterable

from pyros1.bridge.protocol.packets import Definition
from pyros1.ground.errors import Error
from pyros1.msgs import from_definition

_RETRY_PERIOD = 2.0
"""Seconds after which a site is asked again for a definition that has not arrived."""
_MAX_ASKED = 5_000
"""Maximum number of requested definitions remembered for each site."""
SITE_DEFINITIONS = 2_500
"""Maximum number of definitions from a run of a site: more than the number of topics it may have here."""
SITE_CHARACTERS = 16 << 20
"""Maximum total length in characters of the definitions from a run of a site; at least one is kept."""
_Id = tuple[str, str]  # type and md5 sum


class _SiteUsage:
    """The number and total length of the definitions from a site."""

    def __init__(self) -> None:
        self.count = 0
        self.characters = 0

    def add(self, text: str) -> None:
        self.count += 1
        self.characters += len(text)

    def remove(self, text: str) -> None:
        self.count -= 1
        self.characters -= len(text)

    def has_room(self, text: str) -> bool:
        return not self.count or (self.count < SITE_DEFINITIONS and self.characters + len(text) <= SITE_CHARACTERS)

    @property
    def is_too_large(self) -> bool:
        return self.count > 1 and (self.count > SITE_DEFINITIONS or self.characters > SITE_CHARACTERS)


class Definitions:
    """The definitions that other sites have sent. Each counts towards the limit of its site, so a site with too many
    blocks only its own topics. Definitions from ended runs are kept, up to a limit, since other sites' topics may use
    them.
    """

    def __init__(self) -> None:
        self._texts: dict[_Id, str] = {}  # most recently used last
        self._owners: dict[_Id, _SiteUsage] = {}
        self._usage: dict[str, _SiteUsage] = {}
        self._ended_usage = _SiteUsage()  # definitions from runs that have ended
        self._asked_at: dict[str, dict[str, float]] = {}  # site -> md5 sum -> when it was asked

    def text(self, type_name: str, md5sum: str) -> str | None:
        """Return a type's definition; empty if it is unusable, None if it has not arrived yet."""
        text = self._texts.pop((type_name, md5sum), None)
        if text is not None:
            self._texts[type_name, md5sum] = text
        return text

    def is_missing(self, site: str, type_name: str, md5sum: str) -> bool:
        """Return whether to ask a site that uses a type for its definition. If another site has sent an unusable one,
        this site is asked once.
        """
        text = self.text(type_name, md5sum)
        return text is None or (not text and md5sum not in self._asked_at.get(site, ()))

    def take_requests(self, site: str, md5sums: Iterable[str], now: float, limit: int) -> list[str]:
        """Return the md5 sums, at most `limit`, of definitions to request from a site now, and record the requests."""
        asked_at = self._asked_at.setdefault(site, {})
        due = [
            md5sum for md5sum in dict.fromkeys(md5sums) if now - asked_at.get(md5sum, float("-inf")) >= _RETRY_PERIOD
        ][:limit]
        asked_at.update(dict.fromkeys(due, now))
        while len(asked_at) > _MAX_ASKED:
            del asked_at[next(iter(asked_at))]
        return due

    def forget(self, site: str) -> None:
        """Forget what a site was asked for, since it is gone or has restarted."""
        self._asked_at.pop(site, None)
        usage = self._usage.pop(site, None)
        if usage is None:
            return
        for key, text in [*self._texts.items()]:
            if self._owners[key] is usage:
                self._owners[key] = self._ended_usage
                self._ended_usage.add(text)
        for key in [*self._texts]:
            if not self._ended_usage.is_too_large:
                break
            if self._owners[key] is self._ended_usage:
                self._remove(key)

    def _remove(self, key: _Id) -> None:
        self._owners.pop(key).remove(self._texts.pop(key))

    def add(self, site: str, definition: Definition) -> bool:
        """Handle a definition that a site has sent; return whether it is kept. It is kept if it was requested, there is
        room, and no other one is known or this one replaces an unusable one. A usable definition is never replaced, so
        no site can disturb other sites' topics.
        """
        key = (definition.type, definition.md5sum)
        known = self._texts.get(key)
        if definition.md5sum not in self._asked_at.get(site, ()) or known:
            return False
        text = checked_text(definition)
        usage = self._usage.setdefault(site, _SiteUsage())
        if text == known or not usage.has_room(text):
            return False
        if known is not None:
            self._remove(key)
        usage.add(text)
        self._texts[key], self._owners[key] = text, usage
        return True


def checked_text(definition: Definition) -> str:
    """Return a definition's text if it matches its md5 sum, otherwise an empty string.

    Messages can be sent without it, but programs that do not have the type installed cannot read them. With a text that
    does not match the md5 sum, a site could change the meaning of a type's fields.
    """
    try:
        definition.text.encode()  # it goes into connection headers
        is_right = from_definition(definition.type, definition.text)._md5sum == definition.md5sum
    except (Error, ValueError):
        is_right = False
    return definition.text if is_right else ""
