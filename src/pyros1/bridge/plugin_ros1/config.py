"""The configuration of a bridge in the dialect of zenoh-plugin-ros1, from command line and YAML file. No I/O."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pyros1.bridge.names import Pattern, SiteNameError, check_site_name
from pyros1.bridge.plugin_ros1.keys import ANY, DIALECT
from pyros1.bridge.plugin_ros1.rules import PluginRules
from pyros1.bridge.rules.file_reader import Path, RulesError
from pyros1.bridge.rules.parsing import SiteFileReader, parse_topic
from pyros1.bridge.rules.rules import Rule, Rules
from pyros1.values.reading import YamlError, load_yaml

_KEYS = (
    *("dialect", "namespace", "to", "listen", "keys", "prefix", "send", "take", "serve", "call"),
    *("deny_send", "deny_take", "deny_serve", "deny_call", "old_keys"),
)
_SEND_KEYS = ("topic", "here", "rate", "size", "age", "priority", "delivery")
_TAKE_KEYS = ("topic", "here", "rate", "size")
_SERVICE_KEYS = ("service", "here")


@dataclass(frozen=True)
class PluginConfig:
    """The configuration of a bridge in the dialect of zenoh-plugin-ros1.

    Attributes:
        rules: what it exchanges.
        connect, listen: endpoints such as ``tcp/robot:7447``.
        keys: the folder of its keys; empty for none.
        places: endpoint or name of a site in a file -> its file and line, for error messages.
    """

    rules: PluginRules
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()
    keys: str = ""
    places: Mapping[str, str] = field(default_factory=dict)


def check_dialect(name: str) -> str:
    """Return a valid dialect name unchanged.

    Raises:
        RulesError: there is no such dialect.
    """
    if name != DIALECT:
        raise RulesError(f"there is no dialect {name!r:.80}; use {DIALECT}, or none for pyros1 bridges")
    return name


def names_dialect(text: str, where: str) -> bool:
    """Return whether a file names a dialect; False if it is not valid YAML."""
    try:
        value = load_yaml(text, where)
    except YamlError:
        return False  # reading the whole file reports the problem
    return isinstance(value, dict) and "dialect" in value


def make_config(
    namespace: str,
    send: Iterable[str],
    take: Iterable[str],
    serve: Iterable[str],
    call: Iterable[str],
    old_keys: bool = False,
    file: PluginConfig | None = None,
) -> PluginConfig:
    """Return the configuration from a command line and a file. The rules on the command line come first.

    Args:
        namespace: the bridge's namespace; empty for the file's namespace, if any.
        send, take, serve, call: words as for `pyros1.bridge.rules.parsing.parse_topic`.
        old_keys: whether the other bridges are older than March 2025.
        file: the file's configuration, if any.

    Raises:
        RulesError: a word is not valid.
    """
    base = file or PluginConfig(PluginRules(Rules(ANY), Rules(ANY)))
    name = _check_namespace(namespace) if namespace else base.rules.namespace
    rules = PluginRules(
        _add_words(base.rules.topics, name, send, take),
        _add_words(base.rules.services, name, serve, call),
        old_keys or base.rules.old_keys,
    )
    return replace(base, rules=_check(rules))


def _check_namespace(name: str) -> str:
    try:
        return name if name == ANY else check_site_name(name)
    except SiteNameError:
        raise RulesError(
            f"{name!r:.80} cannot be a namespace here: use a letter, then up to 39 letters, digits and underscores"
        ) from None


def _check(rules: PluginRules) -> PluginRules:
    if rules.old_keys and rules.namespaces() != {ANY}:
        raise RulesError(
            "bridges older than March 2025 have no namespaces, so --old-keys cannot be combined with a namespace"
        )
    return rules


def _add_words(rules: Rules, namespace: str, outgoing: Iterable[str], incoming: Iterable[str]) -> Rules:
    sent, taken = [parse_topic(word) for word in outgoing], [parse_topic(word) for word in incoming]
    return replace(
        rules,
        site=namespace,
        send=(*_allowed(sent), *rules.send),
        take=(*_allowed(taken), *rules.take),
        deny_send=(*_denied(sent), *rules.deny_send),
        deny_take=(*_denied(taken), *rules.deny_take),
    )


def _allowed(parsed: Iterable[tuple[bool, Rule]]) -> tuple[Rule, ...]:
    return tuple(rule for allows, rule in parsed if allows)


def _denied(parsed: Iterable[tuple[bool, Rule]]) -> tuple[Pattern, ...]:
    return tuple(rule.pattern for allows, rule in parsed if not allows)


def parse_plugin_config(text: str, where: str) -> PluginConfig:
    """Return the configuration in a file.

    Args:
        text: the file's contents.
        where: its name, for errors.

    Raises:
        RulesError: the file is not valid; the message contains file and line.
        YamlError: it is not valid YAML.
    """
    return _PluginFileReader(text, where).read_plugin()


class _PluginFileReader(SiteFileReader):
    """Reads the values of a file of this dialect."""

    def read_plugin(self) -> PluginConfig:
        """Return the configuration."""
        file = self._mapping(self._value, (), _KEYS)
        self._checked(("dialect",), check_dialect, self._text(file.get("dialect", DIALECT), ("dialect",)))
        namespace = self._text(file.get("namespace", ANY), ("namespace",))
        namespace = self._checked(("namespace",), _check_namespace, namespace)
        prefixes = self._prefixes(file.get("prefix"))
        old_keys = file.get("old_keys", False)
        if not isinstance(old_keys, bool):
            self._fail(("old_keys",), f"expected true or false, not {old_keys!r:.40}")
        topics = Rules(
            namespace,
            tuple(self._rule(item, path, _SEND_KEYS) for item, path in self._items(file, "send")),
            tuple(self._rule(item, path, _TAKE_KEYS) for item, path in self._items(file, "take")),
            self._denied(file, "deny_send"),
            self._denied(file, "deny_take"),
            prefixes,
        )
        services = Rules(
            namespace,
            tuple(self._service(item, path) for item, path in self._items(file, "serve")),
            tuple(self._service(item, path) for item, path in self._items(file, "call")),
            self._denied(file, "deny_serve"),
            self._denied(file, "deny_call"),
            prefixes,
        )
        rules = self._checked((), _check, PluginRules(topics, services, old_keys))
        connect, listen = self._endpoints(file, "to"), self._endpoints(file, "listen")
        return PluginConfig(rules, connect, listen, self._text(file.get("keys", ""), ("keys",)), self.places)

    def _denied(self, file: dict[str, Any], key: str) -> tuple[Pattern, ...]:
        return tuple(self._pattern(item, path) for item, path in self._items(file, key))

    def _service(self, value: Any, path: Path) -> Rule:
        if isinstance(value, str):
            return Rule(self._pattern(value, path))
        fields = self._mapping(value, path, _SERVICE_KEYS)
        if "service" not in fields:
            self._fail(path, "a rule needs a service, for example service: /spawn")
        pattern = self._pattern(fields["service"], (*path, "service"))
        return Rule(pattern, self._here(fields.get("here"), (*path, "here"), pattern))
