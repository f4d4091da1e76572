"""What a new package is to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass
class NewPackage:
    """What a package is to be.

    Attributes:
        name: of the package.
        depends: packages that it needs, to build and to run.
        system: what it needs of the system, as rosdep names it.
        boost: components of Boost to be linked with.
        version, description, licenses, authors, maintainers: for package.xml; people as ``Name <address>``.
        meta: a package that only stands for others.
        examples: with nodes, a message and a launch file.
    """

    name: str
    depends: Sequence[str] = ()
    system: Sequence[str] = ()
    boost: Sequence[str] = ()
    version: str = "0.0.0"
    description: str = ""
    licenses: Sequence[str] = ()
    authors: Sequence[str] = ()
    maintainers: Sequence[str] = ()
    meta: bool = False
    examples: bool = True
