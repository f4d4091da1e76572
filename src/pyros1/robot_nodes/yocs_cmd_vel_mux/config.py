"""The configuration of cmd_vel_mux, which is a YAML document rather than parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.robot_nodes.shared.twist_sources import Source, read_sources
from pyros1.robot_nodes.shared.user_files import yaml_number
from pyros1.values.reading import load_yaml

DEFAULT_OUTPUT = "output"


class ConfigError(Error):
    """A configuration cannot be used."""


class Config(NamedTuple):
    """The configuration of cmd_vel_mux.

    Attributes:
        sources: the sources of commands.
        output: the topic to publish.
    """

    sources: list[Source]
    output: str = DEFAULT_OUTPUT


def read_config(text: str, where: str) -> Config:
    """Return the configuration in a YAML document.

    It has ``subscribers``, a list of mappings with name, topic, timeout and priority; and optionally ``publisher``, a
    topic.

    Args:
        text: the document.
        where: the file's name, for errors.

    Raises:
        YamlError: the text is not YAML.
        ConfigError, SourceError: the document is not a valid configuration.
    """
    value = load_yaml(text, where)
    if not isinstance(value, Mapping) or "subscribers" not in value:
        raise ConfigError(f"{where} needs a list of subscribers")
    output = value.get("publisher", DEFAULT_OUTPUT)
    if not isinstance(output, str) or not output:
        raise ConfigError(f"{where}: publisher must be a topic, not {one_line(repr(output), 100)}")
    return Config(read_sources(_with_numbers(value["subscribers"]), f"{where}: subscribers"), output)


def _with_numbers(sources: Any) -> Any:
    """Return a list of sources in which values such as 1e-1, which are strings in YAML 1.1, are numbers."""
    if not isinstance(sources, list):
        return sources
    return [_with_number(_with_number(source, "timeout"), "priority") for source in sources]


def _with_number(source: Any, key: str) -> Any:
    if not isinstance(source, Mapping) or not isinstance(source.get(key), str):
        return source
    number = yaml_number(source[key])
    return source if number is None else {**source, key: number}
