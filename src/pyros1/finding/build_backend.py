"""The build backend of this project (PEP 517, PEP 660): generates the message stubs, then calls setuptools.

So wheels and editable installs have up-to-date stubs for all definitions that come with pyros1.
"""

from __future__ import annotations

import warnings
from typing import Any

from setuptools import build_meta  # type: ignore[import-untyped]  # has no types
from setuptools.build_meta import (  # type: ignore[import-untyped]  # as above
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

from pyros1.finding import stubs

Settings = dict[str, Any] | None
# Data folders are not declared as packages: modules lose their executable bit, which the scripts of ROS packages need.
warnings.filterwarnings("ignore", r"(?s).*is absent from the `packages` configuration")


def make_stubs() -> None:
    """Write the stubs for the definitions that come with pyros1, and remove all other stubs."""
    library = stubs.shipped_library()
    for stub in stubs.STUBS_FOLDER.glob("*/*.pyi"):  # stubs of the user's own packages do not belong in the wheel
        stub.unlink()
    stubs.write_stubs(stubs.generate_stubs(library, library.packages()), stubs.STUBS_FOLDER)


def build_wheel(wheel_directory: str, config_settings: Settings = None, metadata_directory: str | None = None) -> str:
    """Build a wheel; see PEP 517."""
    make_stubs()
    return str(build_meta.build_wheel(wheel_directory, config_settings, metadata_directory))


def build_editable(
    wheel_directory: str, config_settings: Settings = None, metadata_directory: str | None = None
) -> str:
    """Build an editable wheel; see PEP 660."""
    make_stubs()
    return str(build_meta.build_editable(wheel_directory, config_settings, metadata_directory))


__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]
