"""The description of a new package."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field


@dataclass
class NewPackage:
    """The description of a new package.

    Attributes:
        name: name of the package.
        depends: packages on which it depends for building and running.
        runs: packages on which it depends for running only.
        system: rosdep keys of its system dependencies.
        boost: Boost components to link with.
        version, description, licenses, authors, maintainers: content of package.xml; people as ``Name <address>``.
        meta: whether it is a metapackage.
        examples: whether to add example nodes, a message and a launch file.
        files: further files: path in the package -> text. Files that begin with ``#!`` are made executable.
    """

    name: str
    depends: Sequence[str] = ()
    runs: Sequence[str] = ()
    system: Sequence[str] = ()
    boost: Sequence[str] = ()
    version: str = "0.0.0"
    description: str = ""
    licenses: Sequence[str] = ()
    authors: Sequence[str] = ()
    maintainers: Sequence[str] = ()
    meta: bool = False
    examples: bool = True
    files: Mapping[str, str] = field(default_factory=dict)
