"""The configuration of cmd_vel_mux, which is a YAML document rather than parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.robot_nodes.shared.twist_sources import Source, read_sources
from pyros1.values.reading import load_yaml

DEFAULT_OUTPUT = "output"


class ConfigError(Error):
    """A configuration cannot be used."""


class Config(NamedTuple):
    """A configuration.

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
        ConfigError, SourceError: its value is something else.
    """
    value = load_yaml(text, where)
    if not isinstance(value, Mapping) or "subscribers" not in value:
        raise ConfigError(f"{where} needs a list of subscribers")
    output = value.get("publisher", DEFAULT_OUTPUT)
    if not isinstance(output, str) or not output:
        raise ConfigError(f"{where}: publisher must be a topic, not {one_line(repr(output), 100)}")
    return Config(read_sources(value["subscribers"], f"{where}: subscribers"), output)
