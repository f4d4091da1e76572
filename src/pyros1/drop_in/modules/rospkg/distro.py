"""The ROS distribution of this machine, and files that describe distributions of rosbuild's times (REP 137's
forerunner, https://wiki.ros.org/rosdistro).
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from typing import Any

import yaml

from pyros1.drop_in.missing import missing
from rospkg._distro_vcs import (
    TARBALL_URI_EVAL,
    TARBALL_VERSION_EVAL,
    BzrConfig,
    DvcsConfig,
    GitConfig,
    HgConfig,
    SvnConfig,
    VcsConfig,
    get_vcs_configs,
    load_vcs_config,
)
from rospkg.common import ResourceNotFound
from rospkg.environment import get_etc_ros_dir

__getattr__ = missing(__name__)
__all__ = [
    "TARBALL_URI_EVAL",
    "TARBALL_VERSION_EVAL",
    "BzrConfig",
    "Distro",
    "DistroStack",
    "DvcsConfig",
    "GitConfig",
    "HgConfig",
    "InvalidDistro",
    "SvnConfig",
    "Variant",
    "VcsConfig",
    "current_distro_codename",
    "distro_to_rosinstall",
    "distro_uri",
    "expand_rule",
    "get_vcs_configs",
    "load_distro",
    "load_vcs_config",
]
_MOST_BYTES = 16 << 20
_SECONDS = 60.0
_DEPTH = 50
"""How many variants may extend one another."""


class InvalidDistro(Exception):
    """A file does not describe a distribution."""


def current_distro_codename(env: Mapping[str, str] | None = None) -> str | None:
    """Return ROS_DISTRO, or what the file ``distro`` of ROS_ETC_DIR says; None without them."""
    environ = os.environ if env is None else env
    if "ROS_DISTRO" in environ:
        return environ["ROS_DISTRO"]
    path = os.path.join(get_etc_ros_dir(env=environ), "distro")
    if not os.path.isfile(path):
        return None
    with open(path, encoding="utf-8") as file:
        return file.read(1000).strip()


def distro_uri(distro_name: str) -> str:
    """Return where the description of a distribution was."""
    return f"http://svn.code.sf.net/p/ros-dry-releases/code/trunk/distros/{distro_name}.rosdistro"


def expand_rule(rule: str, stack_name: str, stack_ver: str | None, release_name: str) -> str:
    """Put names and version into a rule; without a version, ``$STACK_VERSION`` stays."""
    values = {"$STACK_NAME": stack_name, "$STACK_VERSION": stack_ver, "$RELEASE_NAME": release_name}
    for key, value in values.items():
        if value or key != "$STACK_VERSION":
            rule = rule.replace(key, value or "")
    return rule


class DistroStack:
    """A stack of a distribution.

    Args:
        stack_name: its name.
        stack_version: None if it is not released.
        release_name: the distribution.
        rules: where its sources are.

    Attributes:
        vcs_config: `VcsConfig`, None if the rules name no system that is known. repo: name of its repository.
    """

    def __init__(self, stack_name: str, stack_version: Any, release_name: str, rules: dict[str, Any]) -> None:
        self.name, self.version, self.release_name = stack_name, stack_version, release_name
        self.repo = rules.get("repo")
        self.vcs_config = load_vcs_config(
            rules, lambda rule: expand_rule(rule, stack_name, stack_version, release_name)
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, DistroStack) and (self.name, self.version, self.vcs_config) == (
            other.name,
            other.version,
            other.vcs_config,
        )

    __hash__ = None  # type: ignore[assignment]  # it can change


class Variant:
    """A set of stacks.

    Args:
        variant_name: its name.
        extends: names of the variants in it.
        stack_names: its own stacks.
        stack_names_implicit: these, and those of the variants in it.
    """

    def __init__(
        self, variant_name: str, extends: list[str], stack_names: list[str], stack_names_implicit: list[str]
    ) -> None:
        self.name = variant_name
        self.extends = extends
        self._names = {False: stack_names, True: stack_names_implicit}

    def get_stack_names(self, implicit: bool = True) -> list[str]:
        """Return the names of its stacks, with those of the variants in it or without."""
        return self._names[bool(implicit)]

    stack_names = property(get_stack_names)


class Distro:
    """A distribution.

    Args:
        stacks: name -> `DistroStack`.
        variants: name -> `Variant`.
        release_name, version: of the distribution.
        raw_data: the file's contents.
    """

    def __init__(
        self,
        stacks: dict[str, DistroStack],
        variants: dict[str, Variant],
        release_name: str,
        version: Any,
        raw_data: dict[str, Any],
    ) -> None:
        self._stacks = stacks
        self.variants, self.release_name, self.version, self.raw_data = variants, release_name, version, raw_data

    def get_stacks(self, released: bool = False) -> dict[str, DistroStack]:
        """Return name -> `DistroStack`, of all or only of those that have a version."""
        return {name: stack for name, stack in self._stacks.items() if stack.version or not released}

    stacks = property(get_stacks)
    released_stacks = property(lambda self: self.get_stacks(True))


def load_distro(source_uri: str) -> Distro:
    """Return the distribution that a file describes.

    Args:
        source_uri: its path or URL.

    Raises:
        InvalidDistro: it describes none.
        ResourceNotFound: it is not there.
    """
    try:
        data = yaml.safe_load(_read(source_uri))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InvalidDistro(str(error)) from error
    if not isinstance(data, dict):
        raise InvalidDistro(f"Distro must be a dictionary: {source_uri}")
    try:
        version = _version(str(data.get("version", "0")))
        release = data["release"]
        stacks = dict(_stacks(data, release))
        return Distro(stacks, _variants(data.get("variants")), release, version, data)
    except KeyError as error:
        raise InvalidDistro(f"distro is missing required '{error}' key") from error


def _read(source: str) -> str:
    if os.path.isfile(source):
        with open(source, encoding="utf-8") as file:
            return file.read(_MOST_BYTES)
    from urllib.request import urlopen

    try:
        with urlopen(source, timeout=_SECONDS) as answer:  # the caller names the address
            data: bytes = answer.read(_MOST_BYTES)
    except (OSError, ValueError) as error:
        raise ResourceNotFound(f"{error} ({source})") from error
    return data.decode()


def _version(text: str) -> Any:
    """Return a version; Subversion's keyword gives ``r`` and its number, or 0 if that was not filled in."""
    if text == "$Revision$":
        return 0
    keyword = re.search(r"\$Revision:\s*(\d*)\s*\$", text)
    version = f"r{keyword[1]}" if keyword else text
    if re.search(r"[^A-Za-z0-9.+~]", version):
        raise InvalidDistro(f"Version string {version} not valid")
    return version


def _stacks(data: dict[str, Any], release: str) -> Iterator[tuple[str, DistroStack]]:
    if "stacks" not in data:
        raise InvalidDistro("distro is missing required 'stacks' key")
    stacks = data["stacks"] or {}
    for name, facts in stacks.items():
        if name[0] == "_":
            continue
        rules = facts["_rules"] if "_rules" in facts else stacks.get("_rules")
        if isinstance(rules, str):
            if rules not in data.get("_rules", {}):
                raise InvalidDistro(f"no _rules named [{rules}]")
            rules = data["_rules"][rules]
        if rules is not None and not isinstance(rules, dict):
            raise InvalidDistro(f"invalid rules: {rules} {type(rules)}")
        if not rules:
            raise InvalidDistro(f"no VCS rules for stack [{name}]")
        yield name, DistroStack(name, facts.get("version"), release, rules)


def _variants(listed: Any) -> dict[str, Variant]:
    facts: dict[str, Any] = {}
    for each in listed or ():
        if not isinstance(each, dict) or len(each) != 1:
            raise InvalidDistro(f"invalid variant spec: {each}")
        facts.update(each)

    def variant(name: str, depth: int) -> Variant:
        if depth > _DEPTH:
            raise InvalidDistro(f"variant [{name}] extends itself")
        own, extends = facts[name].get("stacks", []), facts[name].get("extends", [])
        extends = [extends] if isinstance(extends, str) else extends
        names = list(own)
        for other in extends:
            names = [*variant(other, depth + 1).get_stack_names(), *names]
        return Variant(name, extends, own, names)

    return {name: variant(name, 0) for name in facts}


def distro_to_rosinstall(
    distro: Distro,
    branch: str,
    variant_name: str | None = None,
    implicit: bool = True,
    released_only: bool = True,
    anonymous: bool = True,
) -> list[dict[str, Any]]:
    """Return the entries of a .rosinstall file.

    Args:
        distro: the distribution.
        branch: ``devel``, ``distro``, ``release`` or ``release-tar``.
        variant_name: take the stacks of a variant only.
        implicit: with those of the variants in it.
        released_only: leave out stacks without a version.
        anonymous: take the addresses for everyone.

    Raises:
        KeyError: a stack is not in the distribution.
        ValueError: there is no such branch.
    """
    released = distro.get_stacks(True)
    names = set(distro.variants[variant_name].get_stack_names(implicit)) if variant_name else released
    return [
        entry
        for name in names
        if name in released or not released_only
        for entry in distro.get_stacks()[name].vcs_config.to_rosinstall(name, branch, anonymous)
    ]
