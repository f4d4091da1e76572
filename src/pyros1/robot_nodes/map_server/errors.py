"""What can be wrong with a map."""

from __future__ import annotations

from pyros1.ground.errors import Error


class MapError(Error):
    """A map cannot be read or written."""


class MapMissingError(MapError):
    """There is no such file, or it may not be read."""


class MapDataError(MapError):
    """The picture of a map is damaged, too large, or of a format that cannot be read."""


class MapMetadataError(MapError):
    """The description of a map (its YAML file) is damaged or incomplete."""
