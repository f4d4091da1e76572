"""Answers of the commands rospack and rosstack."""

from __future__ import annotations

from typing import Any

from rospkg import ResourceNotFound, RosPack, RosStack

from pyros1.drop_in.missing import missing

_WHY = "ask rospkg.RosPack"

python3 = True
__getattr__ = missing(__name__, rospack_plugins=_WHY, rosstackexec=_WHY)


def rospackexec(args: list[str]) -> str:
    """Return what the command would print; empty if it would fail. Some commands only."""
    rospack = RosPack.get_instance()
    commands: dict[str, Any] = {
        "find": rospack.get_path,
        "depends": lambda name: "\n".join(rospack.get_depends(name)),
        "depends1": lambda name: "\n".join(rospack.get_depends(name, implicit=False)),
        "list-names": lambda: "\n".join(rospack.list()),
    }
    if args[0] not in commands:
        raise NotImplementedError(f"pyros1's rospackexec has no {args[0]}")
    try:
        return str(commands[args[0]](*args[1:]))
    except ResourceNotFound:
        return ""


def rospack_depends_1(pkg: str) -> Any:
    """Return the packages that a package needs directly."""
    return RosPack.get_instance().get_depends(pkg, implicit=False)


def rospack_depends(pkg: str) -> Any:
    """Return all packages that a package needs."""
    return RosPack.get_instance().get_depends(pkg)


def rospack_depends_on_1(pkg: str) -> Any:
    """Return the packages that need a package directly."""
    return RosPack.get_instance().get_depends_on(pkg, implicit=False)


def rospack_depends_on(pkg: str) -> Any:
    """Return all packages that need a package."""
    return RosPack.get_instance().get_depends_on(pkg)


def rosstack_depends_1(s: str) -> Any:
    """Return the stacks that a stack needs directly."""
    return RosStack.get_instance().get_depends(s, implicit=False)


def rosstack_depends(s: str) -> Any:
    """Return all stacks that a stack needs."""
    return RosStack.get_instance().get_depends(s)


def rosstack_depends_on_1(s: str) -> Any:
    """Return the stacks that need a stack directly."""
    return RosStack.get_instance().get_depends_on(s, implicit=False)


def rosstack_depends_on(s: str) -> Any:
    """Return all stacks that need a stack."""
    return RosStack.get_instance().get_depends_on(s)
