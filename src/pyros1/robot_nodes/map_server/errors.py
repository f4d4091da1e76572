"""Errors about maps."""

from __future__ import annotations

from pyros1.ground.errors import Error


class MapError(Error):
    """A map cannot be read or written."""


class MapMissingError(MapError):
    """A map's file does not exist, or cannot be read."""


class MapDataError(MapError):
    """A map's image is damaged, too large, or in an unsupported format."""


class MapMetadataError(MapError):
    """The description of a map (its YAML file) is damaged or incomplete."""
