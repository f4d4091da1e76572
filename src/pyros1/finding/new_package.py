"""The description of a new package."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field


@dataclass
class NewPackage:
    """The description of a new package.

    Attributes:
        name: name of the package.
        depends: packages that the new package needs for building and running.
        run_depends: packages that it needs only for running.
        system_depends: rosdep keys of its system dependencies.
        boost: names of the Boost components to link with.
        version, description, licenses, authors, maintainers: content of package.xml; people as ``Name <address>``.
        is_meta: whether it is a metapackage.
        examples: whether to add example nodes, an example message and an example launch file.
        files: further files: path in the package -> text. Files that begin with ``#!`` are made executable.
    """

    name: str
    depends: Sequence[str] = ()
    run_depends: Sequence[str] = ()
    system_depends: Sequence[str] = ()
    boost: Sequence[str] = ()
    version: str = "0.0.0"
    description: str = ""
    licenses: Sequence[str] = ()
    authors: Sequence[str] = ()
    maintainers: Sequence[str] = ()
    is_meta: bool = False
    examples: bool = True
    files: Mapping[str, str] = field(default_factory=dict)
