"""``pkg cflags-only-...`` and ``libs-only-...``: flags of compiler and linker (L182)."""

from __future__ import annotations

import os
import shlex
import subprocess

from pyros1.cli.commands.pkg._graph import DEPS_ONLY, check_known, chosen, graph
from pyros1.cli.commands.pkg._rospack import PkgError, Request, pack_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb


def _flags(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print compiler and linker flags: of catkin packages from pkg-config, of rosbuild packages from their exports."""
    known, name = graph(request)
    check_known(known, name)
    include = request.verb.startswith("cflags")
    kind = request.verb.rsplit("-", 1)[1]  # I, L, l or other
    words: list[str] = []
    done = False
    for manifest in chosen(request, known, name):
        if not manifest.catkin:
            for value in manifest.exported("cpp", "cflags" if include else "lflags"):
                words += _of_kind(shlex.split(value), kind)
        elif not done:
            done = manifest.name == name  # pkg-config's answer includes all dependencies
            words += _of_kind(_pkg_config(request.verb, manifest.name), kind)
    unique = dict.fromkeys(words) if kind != "l" else dict.fromkeys(reversed(words))
    result = [*unique] if kind != "l" else [*reversed(unique)]
    print(" ".join(result))


def _of_kind(words: list[str], kind: str) -> list[str]:
    if kind == "other":
        return [word for word in words if word[:2] not in ("-I", "-L", "-l")]
    return [word[2:] for word in words if word.startswith(f"-{kind}")]


def _pkg_config(verb: str, name: str) -> list[str]:
    environ = dict(os.environ)
    paths = [os.path.join(p, "lib", "pkgconfig") for p in environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if p]
    environ["PKG_CONFIG_PATH"] = os.pathsep.join([*paths, *filter(None, [environ.get("PKG_CONFIG_PATH")])])
    command = ["pkg-config", f"--{verb}", name]
    try:
        done = subprocess.run(command, env=environ, capture_output=True, text=True, check=False)
    except OSError as error:
        raise PkgError(f"cannot run pkg-config: {error.strerror}") from error
    if done.returncode:
        raise PkgError(f"'{' '.join(command)}' failed: {done.stderr.strip()}")
    return shlex.split(done.stdout)


def _verb(name: str, width: int, about: str) -> Verb:
    package = Argument("package", "package", optional=True)
    return pack_verb(
        name, f"{name:{width}} [--deps-only] [package]", DEPS_ONLY, package, run=_flags, examples=[("roscpp", about)]
    )


VERBS = [
    _verb("cflags-only-I", 17, "include folders"),
    _verb("cflags-only-other", 17, "other compiler flags"),
    _verb("libs-only-L", 15, "library folders"),
    _verb("libs-only-l", 15, "libraries"),
    _verb("libs-only-other", 15, "other linker flags"),
]
