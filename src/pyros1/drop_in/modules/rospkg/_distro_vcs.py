"""Where the sources of a stack are, in each system of versions (https://wiki.ros.org/rosdistro)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

TARBALL_URI_EVAL = (
    "http://svn.code.sf.net/p/ros-dry-releases/code/download/stacks/"
    "$STACK_NAME/$STACK_NAME-$STACK_VERSION/$STACK_NAME-$STACK_VERSION.tar.bz2"
)
TARBALL_VERSION_EVAL = "$STACK_NAME-$STACK_VERSION"
Rule = Callable[[str], str]


class VcsConfig:
    """Base of all systems.

    Args:
        type_: name of the system.

    Attributes:
        tarball_url, tarball_version: of the release as an archive.
    """

    _fields: tuple[str, ...] = ()

    def __init__(self, type_: str) -> None:
        self.type = type_
        self.tarball_url: str | None = None
        self.tarball_version: str | None = None

    def load(self, rules: Any, rule_eval: Rule) -> None:
        """Take the rules of a stack.

        Args:
            rules: from the distribution's file.
            rule_eval: puts names and version into a rule.

        Raises:
            KeyError: a rule is missing.
        """
        self.tarball_url = rule_eval(TARBALL_URI_EVAL)
        self.tarball_version = rule_eval(TARBALL_VERSION_EVAL)

    def get_branch(self, branch: str, anonymous: bool) -> tuple[Any, Any]:
        """Return address and version of a branch.

        Args:
            branch: ``release-tar``; most systems have ``devel``, ``distro`` and ``release``, too.
            anonymous: take the address for everyone.

        Raises:
            ValueError: there is no such branch.
        """
        if branch != "release-tar":
            raise ValueError(branch)
        return self.tarball_url, self.tarball_version

    def to_rosinstall(self, local_name: str, branch: str, anonymous: bool) -> list[dict[str, Any]]:
        """Return the entries of a .rosinstall file; arguments and errors as for `get_branch`."""
        uri, version = self.get_branch(branch, anonymous)
        entry = {"uri": uri, "local-name": local_name}
        if version:
            entry["version"] = version
        return [{"tar" if branch == "release-tar" else self.type: entry}]

    def __eq__(self, other: object) -> bool:
        names = ("type", "tarball_url", *self._fields)
        return isinstance(other, VcsConfig) and all(getattr(self, name) == getattr(other, name, None) for name in names)

    __hash__ = None  # type: ignore[assignment]  # it can change


class DvcsConfig(VcsConfig):
    """A system with repositories.

    Attributes:
        repo_uri, anon_repo_uri: address of the repository. dev_branch, distro_tag, release_tag: what is where in it.
    """

    _fields = ("repo_uri", "anon_repo_uri", "dev_branch", "distro_tag", "release_tag")
    _branches = {"devel": "dev_branch", "distro": "distro_tag", "release": "release_tag"}

    def __init__(self, type_: str) -> None:
        super().__init__(type_)
        self.repo_uri: str | None = None
        self.anon_repo_uri: str | None = None
        self.dev_branch: str | None = None
        self.distro_tag: str | None = None
        self.release_tag: str | None = None

    def load(self, rules: Any, rule_eval: Rule) -> None:
        """Take the rules of a stack; see `VcsConfig.load`."""
        super().load(rules, rule_eval)
        self.repo_uri = rule_eval(rules["uri"])
        self.anon_repo_uri = rule_eval(rules["anon-uri"]) if "anon-uri" in rules else self.repo_uri
        for name in ("dev_branch", "distro_tag", "release_tag"):
            setattr(self, name, rule_eval(rules[name.replace("_", "-")]))

    def get_branch(self, branch: str, anonymous: bool) -> tuple[Any, Any]:
        """Return address and version of a branch; see `VcsConfig.get_branch`."""
        if branch == "release-tar":
            return super().get_branch(branch, anonymous)
        if branch not in self._branches:
            raise ValueError(f"invalid branch spec [{branch}]")
        version = getattr(self, self._branches[branch])
        if version is None:
            raise ValueError(f"branch [{branch}] is not available for this config")
        return self.anon_repo_uri if anonymous else self.repo_uri, version


class GitConfig(DvcsConfig):
    """Git."""

    def __init__(self) -> None:
        super().__init__("git")


class HgConfig(DvcsConfig):
    """Mercurial."""

    def __init__(self) -> None:
        super().__init__("hg")


class BzrConfig(DvcsConfig):
    """Bazaar."""

    def __init__(self) -> None:
        super().__init__("bzr")


class SvnConfig(VcsConfig):
    """Subversion, where each branch has an address.

    Attributes:
        dev, distro_tag, release_tag: the addresses; with ``anon_`` in front, those for everyone.
    """

    _fields = ("dev", "distro_tag", "release_tag", "anon_dev", "anon_distro_tag", "anon_release_tag")
    _branches = {"devel": "dev", "distro": "distro_tag", "release": "release_tag"}

    def __init__(self) -> None:
        super().__init__("svn")
        self.dev: str | None = None
        self.distro_tag: str | None = None
        self.release_tag: str | None = None
        self.anon_dev: str | None = None
        self.anon_distro_tag: str | None = None
        self.anon_release_tag: str | None = None

    def load(self, rules: Any, rule_eval: Rule) -> None:
        """Take the rules of a stack; see `VcsConfig.load`."""
        super().load(rules, rule_eval)
        prefix = "anon-" if "anon-dev" in rules else ""
        for name in self._branches.values():
            key = name.replace("_", "-")
            if key not in rules:
                raise KeyError(f"svn rules missing required {key} key: {rules}")
            setattr(self, name, rule_eval(rules[key]))
            setattr(self, f"anon_{name}", rule_eval(rules[prefix + key]))

    def get_branch(self, branch: str, anonymous: bool) -> tuple[Any, Any]:
        """Return address and version of a branch; see `VcsConfig.get_branch`.

        Raises:
            KeyError: there is no such branch.
            ValueError: it has no address.
        """
        if branch == "release-tar":
            return super().get_branch(branch, anonymous)
        if branch not in self._branches:
            raise KeyError(f"invalid branch spec [{branch}]")
        uri = getattr(self, ("anon_" if anonymous else "") + self._branches[branch])
        if uri is None:
            raise ValueError(f"branch [{branch}] is not available for this config")
        return uri, None


def get_vcs_configs() -> dict[str, Callable[[], VcsConfig]]:
    """Return name -> class of all systems."""
    return {"svn": SvnConfig, "git": GitConfig, "hg": HgConfig, "bzr": BzrConfig}


def load_vcs_config(rules: dict[str, Any], rule_eval: Rule) -> Any:
    """Return the `VcsConfig` of a stack's rules, None if they name no system that is known; see `VcsConfig.load`."""
    for name, cls in get_vcs_configs().items():
        if name in rules:
            config = cls()
            config.load(rules[name], rule_eval)
            return config
    return None
