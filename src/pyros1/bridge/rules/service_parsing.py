"""Parses rules about services and parameters, from command-line arguments and a site's file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from pyros1.bridge.names import Pattern, SiteNameError
from pyros1.bridge.protocol.calls import MAX_TIME
from pyros1.bridge.rules.file_reader import FileReader, Path
from pyros1.bridge.rules.rules import Rule, Rules, ServiceRules

SERVICE_SETTINGS = ("serve", "call", "deny_serve", "deny_call", "params", "deny_params")
"""The settings in a site's file that this module reads."""
_RULE_KEYS = ("service", "here", "sites", "timeout")


def service_pattern(text: str) -> Pattern:
    """Parse a pattern of services.

    Raises:
        SiteNameError: it is not one.
    """
    try:
        return Pattern(text)
    except SiteNameError:
        raise SiteNameError(
            f"{text!r:.80} is not a pattern of services: write /set_map, /camera/**, red:/spawn, red:** or *:/spawn"
        ) from None


def own_pattern(text: str, what: str = "services") -> Pattern:
    """Parse a pattern of this site's services or parameters.

    Raises:
        SiteNameError: it is not one.
    """
    pattern = service_pattern(text)
    if pattern.site:
        raise SiteNameError(
            f"{text!r:.80} is another site's, but only {what} of this site can be named here: write /name"
        )
    return pattern


def other_pattern(text: str) -> Pattern:
    """Parse a pattern of other sites' services.

    Raises:
        SiteNameError: it is not one.
    """
    pattern = service_pattern(text)
    if not pattern.site:
        raise SiteNameError(f"{text!r:.80} does not say whose service it is: write red:/name, red:** or *:/name")
    return pattern


def parse_parameter(text: str) -> Pattern:
    """Parse a pattern of this site's parameters.

    Raises:
        SiteNameError: it is not one.
    """
    try:
        return own_pattern(text, "parameters")
    except SiteNameError:
        raise SiteNameError(
            f"{text!r:.80} is not a pattern of parameters: write /robot_description or /camera/**"
        ) from None


def add_service_words(rules: Rules, serve: Iterable[str], call: Iterable[str], params: Iterable[str]) -> Rules:
    """Return rules with additional ones from a command line, which come first and so take precedence.

    Args:
        rules: the rules.
        serve, call, params: patterns; ``!`` before one denies.

    Raises:
        SiteNameError: a word is not valid.
    """
    (served, not_served), (called, not_called) = _parse(serve, own_pattern), _parse(call, other_pattern)
    readable, not_readable = _parse(params, parse_parameter)
    old = rules.services
    services = ServiceRules(
        tuple(map(Rule, served)) + old.serve,
        tuple(map(Rule, called)) + old.call,
        not_served + old.deny_serve,
        not_called + old.deny_call,
        readable + old.params,
        not_readable + old.deny_params,
    )
    return replace(rules, services=services)


def _parse(words: Iterable[str], parse: Callable[[str], Pattern]) -> tuple[tuple[Pattern, ...], tuple[Pattern, ...]]:
    """Return the patterns that allow, and those that deny."""
    found = [(word.startswith("!"), parse(word.removeprefix("!"))) for word in words]
    return tuple(each for denies, each in found if not denies), tuple(each for denies, each in found if denies)


class ServiceReader(FileReader):
    """Reads the settings of services and parameters in a site's file; a base class for the reader of all settings,
    which defines the functions declared here.
    """

    _sites: Callable[[Mapping[str, Any], Path], tuple[str, ...]]
    _number: Callable[[Mapping[str, Any], Path, str, float], float | None]
    _here: Callable[[Any, Path, Pattern], str]

    def read_services(self, file: Mapping[str, Any]) -> ServiceRules:
        """Return the rules about services and parameters in a file."""
        return ServiceRules(
            tuple(self._service_rule(item, path, own_pattern) for item, path in self._items(file, "serve")),
            tuple(self._service_rule(item, path, other_pattern) for item, path in self._items(file, "call")),
            *(
                tuple(self._service_patterns(file, key, parse))
                for key, parse in (
                    ("deny_serve", own_pattern),
                    ("deny_call", other_pattern),
                    ("params", parse_parameter),
                    ("deny_params", parse_parameter),
                )
            ),
        )

    def _service_patterns(self, file: Mapping[str, Any], key: str, parse: Callable[[str], Pattern]) -> list[Pattern]:
        return [self._service_pattern(item, path, parse) for item, path in self._items(file, key)]

    def _service_pattern(self, value: Any, path: Path, parse: Callable[[str], Pattern]) -> Pattern:
        text = self._text(value, path)
        if text.startswith("!"):
            self._fail(path, "write what is not allowed under deny_serve, deny_call or deny_params, without !")
        pattern: Pattern = self._checked(path, parse, text)
        return pattern

    def _service_rule(self, value: Any, path: Path, parse: Callable[[str], Pattern]) -> Rule:
        if isinstance(value, str):
            return Rule(self._service_pattern(value, path, parse))
        fields = self._mapping(value, path, _RULE_KEYS)
        if "service" not in fields:
            self._fail(path, "a rule needs a service, for example service: /set_map")
        pattern = self._service_pattern(fields["service"], (*path, "service"), parse)
        return Rule(
            pattern,
            self._here(fields.get("here"), (*path, "here"), pattern),
            self._sites(fields, path),
            timeout=self._number(fields, path, "timeout", MAX_TIME),
        )
