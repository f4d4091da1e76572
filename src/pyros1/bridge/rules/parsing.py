"""Rules from text: the words of a command line, and the YAML file of a site."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pyros1.bridge.conversions.conversion import SETTINGS, Conversion, ConversionError, read_conversion
from pyros1.bridge.names import Pattern, SiteNameError, check_site_name, is_topic_name
from pyros1.bridge.rules.file_reader import Path, RulesError
from pyros1.bridge.rules.rules import LOSS_DELAY, Priority, Rule, Rules
from pyros1.bridge.rules.service_parsing import SERVICE_SETTINGS, ServiceReader
from pyros1.bridge.rules.site_access import named_sites
from pyros1.bridge.rules.sites_reader import SitesReader
from pyros1.ground.suggest import did_you_mean

_MIN_LOSS, _MAX_LOSS = 1.0, 60.0
_MAX_RATE = 10_000.0
_MAX_AGE = 86_400.0
_MAX_SIZE = 64 << 20
_UNITS = {"": 1, "B": 1, "KB": 1000, "MB": 1000**2, "GB": 1000**3, "KIB": 1 << 10, "MIB": 1 << 20, "GIB": 1 << 30}
_SIZE = re.compile(r"(\d{1,12}(?:\.\d{1,6})?)\s*([A-Za-z]{0,3})\Z")
_COMMON_KEYS = ("topic", "here", "sites", "rate", "size", "age")
_TAKE_KEYS = (*_COMMON_KEYS, "prefix_frames", "keep_frames")
_SEND_KEYS = (*_COMMON_KEYS, "priority", "delivery", *SETTINGS)
"""The settings of rules. The sender decides on priority, delivery and conversions."""
_FRAME = re.compile(r"[A-Za-z0-9_.-]+(/[A-Za-z0-9_.-]+)*\Z", re.ASCII)


@dataclass(frozen=True)
class SiteConfig:
    """A site's configuration, from command line and file.

    Attributes:
        rules: the site's rules.
        connect, listen: endpoints such as ``tls/base.example:7447``.
        keys: the folder of the site's keys; empty for none.
        places: endpoint or name of a site in a file -> its file and line, for error messages.
    """

    rules: Rules
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()
    keys: str = ""
    places: Mapping[str, str] = field(default_factory=dict)


def parse_topic(text: str) -> tuple[bool, Rule]:
    """Return whether a word such as ``/scan@5`` or ``!/camera/**`` allows, and its rule.

    Args:
        text: a pattern; ``!`` before it denies, ``@5`` after it limits the messages per second.

    Raises:
        RulesError: the text is not valid.
    """
    allows = not text.startswith("!")
    pattern_text, at, rate_text = text.removeprefix("!").partition("@")
    try:
        pattern = Pattern(pattern_text)
    except SiteNameError as error:
        raise RulesError(str(error)) from None
    if not at:
        return allows, Rule(pattern)
    if not allows:
        raise RulesError(f"{text!r:.80} denies a topic, so it cannot have a rate")
    try:
        rate = float(rate_text)
    except ValueError:
        rate = math.nan
    return allows, Rule(pattern, rate=_check_number(rate, f"{text!r:.80}: the rate after @", _MAX_RATE))


def rules_from_arguments(site: str, send: Iterable[str], take: Iterable[str]) -> Rules:
    """Return the rules given by command-line arguments.

    Args:
        site: the site's name.
        send, take: words as for `parse_topic`.

    Raises:
        RulesError: a word is not valid.
    """
    try:
        check_site_name(site)
    except SiteNameError as error:
        raise RulesError(str(error)) from None
    (sent, not_sent), (received, not_taken) = _parse_words(send), _parse_words(take)
    return Rules(site, sent, received, not_sent, not_taken)


def add_arguments(config: SiteConfig, send: Iterable[str], take: Iterable[str]) -> SiteConfig:
    """Return a site's configuration with additional rules from a command line, which come first and so take precedence.

    Raises:
        RulesError: a word is not valid.
    """
    more, rules = rules_from_arguments(config.rules.site, send, take), config.rules
    combined = replace(
        rules,
        send=more.send + rules.send,
        take=more.take + rules.take,
        deny_send=more.deny_send + rules.deny_send,
        deny_take=more.deny_take + rules.deny_take,
    )
    return replace(config, rules=combined)


def _parse_words(words: Iterable[str]) -> tuple[tuple[Rule, ...], tuple[Pattern, ...]]:
    parsed = [parse_topic(word) for word in words]
    return tuple(rule for allows, rule in parsed if allows), tuple(
        rule.pattern for allows, rule in parsed if not allows
    )


# Files ----------------------------------------------------------------------------------------------------------------


def parse_config(text: str, where: str, site: str = "") -> SiteConfig:
    """Return the configuration in a site's file.

    Args:
        text: the file's contents.
        where: its name, for errors.
        site: the site's name from the command line; empty if it must be in the file.

    Raises:
        RulesError: the file is not valid; the message contains file and line.
        YamlError: it is not valid YAML.
    """
    return SiteFileReader(text, where).read(site)


class SiteFileReader(SitesReader, ServiceReader):
    """Reads the rules in a site's file."""

    def read(self, site: str) -> SiteConfig:
        """Return the site's configuration."""
        keys = ("site", "to", "listen", "keys", "sites", "prefix", "send", "take", "deny_send", "deny_take", "loss")
        file = self._mapping(self._value, (), (*keys, *SERVICE_SETTINGS))
        access = self._access(file)
        name = site or self._text(file.get("site", ""), ("site",))
        if not name:
            self._fail((), "the file does not say which site it is for: write site: NAME, or use --site NAME")
        rules = Rules(
            self._checked(("site",), check_site_name, name),
            tuple(self._rule(item, path, _SEND_KEYS) for item, path in self._items(file, "send")),
            tuple(self._rule(item, path, _TAKE_KEYS) for item, path in self._items(file, "take")),
            tuple(self._pattern(item, path) for item, path in self._items(file, "deny_send")),
            tuple(self._pattern(item, path) for item, path in self._items(file, "deny_take")),
            self._prefixes(file.get("prefix")),
            named_sites(access),
            access,
            self.read_services(file),
            self._checked(("loss",), check_loss, file["loss"]) if "loss" in file else LOSS_DELAY,
        )
        connect, listen = self._endpoints(file, "to"), self._endpoints(file, "listen")
        return SiteConfig(rules, connect, listen, self._text(file.get("keys", ""), ("keys",)), self.places)

    def _rule(self, value: Any, path: Path, keys: tuple[str, ...]) -> Rule:
        if isinstance(value, str):
            allows, rule = self._checked(path, parse_topic, value)
            if not allows:
                self._fail(path, "write topics that are not allowed under deny_send or deny_take, without !")
            return rule
        if not isinstance(value, dict):
            self._fail(path, f"expected a topic, such as /odom, or a rule with topic: /odom, not {value!r:.40}")
        verb, others = (
            ("send", _SEND_KEYS) if keys is _TAKE_KEYS else ("take", _TAKE_KEYS if keys is _SEND_KEYS else ())
        )
        for key in value:
            if key in others and key not in keys:
                self._fail(
                    (*path, key), f"the site that {verb}s the topic decides on {key}: set it there, under {verb}"
                )
        fields = self._mapping(value, path, keys)
        if "topic" not in fields:
            self._fail(path, "a rule needs a topic, for example topic: /odom")
        pattern = self._pattern(fields["topic"], (*path, "topic"))
        return Rule(
            pattern,
            self._here(fields.get("here"), (*path, "here"), pattern),
            self._sites(fields, path),
            self._number(fields, path, "rate", _MAX_RATE),
            self._size(fields.get("size"), (*path, "size")),
            self._priority(fields.get("priority"), (*path, "priority")),
            self._delivery(fields.get("delivery"), (*path, "delivery")),
            self._number(fields, path, "age", _MAX_AGE),
            None,
            self._conversion(fields, path),
            *self._frames(fields, path),
        )

    def _conversion(self, fields: Mapping[str, Any], path: Path) -> Conversion | None:
        try:
            return read_conversion(fields)
        except ConversionError as error:
            self._fail((*path, error.setting), str(error))

    def _frames(self, fields: Mapping[str, Any], path: Path) -> tuple[str, tuple[str, ...]]:
        """Return the prefix for frames, and the frames that keep their names."""
        prefix = self._frame(fields.get("prefix_frames", ""), (*path, "prefix_frames"))
        kept = tuple(self._frame(item, where) for item, where in self._items(fields, "keep_frames", path))
        if kept and not prefix:
            self._fail((*path, "keep_frames"), "keep_frames is only for rules with prefix_frames")
        return prefix, kept

    def _frame(self, value: Any, path: Path) -> str:
        name = self._text(value, path)
        if name and not _FRAME.match(name):
            self._fail(path, f"{name!r:.80} is not the name of a frame, such as red or red/map")
        return name

    def _pattern(self, value: Any, path: Path) -> Pattern:
        return self._checked(path, Pattern, self._text(value, path))

    def _here(self, value: Any, path: Path, pattern: Pattern) -> str:
        if value is None:
            return ""
        name = self._text(value, path)
        base = name.removesuffix("/**")
        if pattern.is_literal and not is_topic_name(name):
            self._fail(path, f"{name!r:.80} is not the full name of a topic, such as /odom")
        if not pattern.is_literal and (
            pattern.subtree is None or base == name or not (base == "" or is_topic_name(base))
        ):
            self._fail(path, "`here` must end in /** if the pattern does; it cannot be used with other wildcards")
        return name

    def _prefixes(self, value: Any) -> dict[str, str]:
        if value is None:
            return {}
        found = {}
        for site, name in self._mapping(value, ("prefix",), None).items():
            path = ("prefix", site)
            if site != "*":
                self._checked(path, check_site_name, self._text(site, path))
            text = self._text(name, path)
            if text != "/" and not is_topic_name(text):
                self._fail(path, f"{text!r:.80} is not a full name, such as /robots/red, or / for no prefix")
            found[site] = text.rstrip("/")
        return found

    def _sites(self, fields: Mapping[str, Any], path: Path) -> tuple[str, ...]:
        return tuple(
            self._checked(item_path, check_site_name, self._text(item, item_path))
            for item, item_path in self._items(fields, "sites", path)
        )

    def _number(self, fields: Mapping[str, Any], path: Path, key: str, maximum: float) -> float | None:
        value = fields.get(key)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value <= maximum:
            self._fail((*path, key), f"{key} must be a number above 0, at most {maximum:g}, not {value!r:.40}")
        return float(value)

    def _size(self, value: Any, path: Path) -> int | None:
        if value is None:
            return None
        match = _SIZE.match(str(value).strip())
        size = int(float(match[1]) * _UNITS.get(match[2].upper(), 0)) if match else 0
        if not 0 < size <= _MAX_SIZE:
            self._fail(path, f"{value!r:.40} is not a size in bytes up to 64 MiB, such as 2MB")
        return size

    def _priority(self, value: Any, path: Path) -> Priority | None:
        if value is None:
            return None
        names = [priority.name.lower() for priority in Priority]
        name = self._text(value, path)
        if name not in names:
            self._fail(path, f"there is no priority {name!r:.40}{did_you_mean(name, names)}; use {', '.join(names)}")
        return Priority[name.upper()]

    def _delivery(self, value: Any, path: Path) -> bool | None:
        if value is None:
            return None
        if value not in ("reliable", "newest"):
            self._fail(path, f"delivery must be reliable (all messages) or newest, not {value!r:.40}")
        return bool(value == "reliable")


def check_loss(value: Any) -> float:
    """Return the delay in seconds after which a site is lost, from a file or a command line.

    Raises:
        RulesError: it is not valid.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not _MIN_LOSS <= value <= _MAX_LOSS:
        raise RulesError(f"loss must be a number of seconds from {_MIN_LOSS:g} to {_MAX_LOSS:g}, not {value!r:.40}")
    return float(value)


def _check_number(number: float, name: str, maximum: float) -> float:
    if not 0 < number <= maximum:
        raise RulesError(f"{name} must be a number above 0, at most {maximum:g}")
    return float(number)
