"""``pkg cflags-only-...`` and ``libs-only-...``: print the compiler and linker flags of packages (L182)."""

from __future__ import annotations

import os
import shlex
import subprocess

from pyros1.cli.commands.pkg._dependencies import DEPS_ONLY_FLAG, check_known, packages_and_name, selected_manifests
from pyros1.cli.commands.pkg._rospack import PkgError, Request, make_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb


def _print_flags(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print compiler or linker flags, from pkg-config for catkin packages and from exports for rosbuild packages."""
    packages, package_name = packages_and_name(request)
    check_known(packages, package_name)
    is_compiler = request.verb.startswith("cflags")
    flag_kind = request.verb.rsplit("-", 1)[1]  # I, L, l or other
    flags: list[str] = []
    has_pkg_config_flags = False
    for manifest in selected_manifests(request, packages, package_name):
        if not manifest.is_catkin:
            for value in manifest.exported_values("cpp", "cflags" if is_compiler else "lflags"):
                flags += _select_flags(shlex.split(value), flag_kind)
        elif not has_pkg_config_flags:
            has_pkg_config_flags = manifest.name == package_name  # pkg-config's output includes all dependencies
            flags += _select_flags(_run_pkg_config(request.verb, manifest.name), flag_kind)
    unique_flags = dict.fromkeys(flags) if flag_kind != "l" else dict.fromkeys(reversed(flags))
    print(" ".join(unique_flags if flag_kind != "l" else reversed(unique_flags)))


def _select_flags(flags: list[str], flag_kind: str) -> list[str]:
    if flag_kind == "other":
        return [flag for flag in flags if flag[:2] not in ("-I", "-L", "-l")]
    return [flag[2:] for flag in flags if flag.startswith(f"-{flag_kind}")]


def _run_pkg_config(verb: str, package_name: str) -> list[str]:
    environ = dict(os.environ)
    pkg_config_paths = [
        os.path.join(prefix, "lib", "pkgconfig")
        for prefix in environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
        if prefix
    ]
    environ["PKG_CONFIG_PATH"] = os.pathsep.join([*pkg_config_paths, *filter(None, [environ.get("PKG_CONFIG_PATH")])])
    command = ["pkg-config", f"--{verb}", package_name]
    try:
        result = subprocess.run(command, env=environ, capture_output=True, text=True, check=False)
    except OSError as error:
        raise PkgError(f"cannot run pkg-config: {error.strerror}") from error
    if result.returncode:
        raise PkgError(f"'{' '.join(command)}' failed: {result.stderr.strip()}")
    return shlex.split(result.stdout)


def _make_verb(name: str, width: int, about: str) -> Verb:
    package_argument = Argument("package", "package", optional=True)
    return make_verb(
        name,
        f"{name:{width}} [--deps-only] [package]",
        DEPS_ONLY_FLAG,
        package_argument,
        run=_print_flags,
        examples=[("roscpp", about)],
    )


VERBS = [
    _make_verb("cflags-only-I", 17, "print include folders"),
    _make_verb("cflags-only-other", 17, "print other compiler flags"),
    _make_verb("libs-only-L", 15, "print library folders"),
    _make_verb("libs-only-l", 15, "print libraries"),
    _make_verb("libs-only-other", 15, "print other linker flags"),
]
