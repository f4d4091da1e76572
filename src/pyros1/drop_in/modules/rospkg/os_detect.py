"""Name and version of the operating system, from /etc/os-release (https://www.freedesktop.org/software/systemd/man/)."""

from __future__ import annotations

import os
import platform
import sys

from pyros1.drop_in.missing import missing

OS_DEBIAN, OS_UBUNTU, OS_FEDORA, OS_ARCH, OS_ALPINE, OS_GENTOO = (
    "debian",
    "ubuntu",
    "fedora",
    "arch",
    "alpine",
    "gentoo",
)
OS_OSX, OS_WINDOWS = "osx", "windows"
__getattr__ = missing(__name__, OsDetector="pyros1 asks /etc/os-release only")


class OsNotDetected(Exception):
    """The operating system is not known."""


class OsDetect:
    """Knows the operating system. ``ROS_OS_OVERRIDE``, as ``name:version:codename``, is asked first.

    Args:
        os_list: accepted for stock's sake: /etc/os-release has all that there are.
    """

    def __init__(self, os_list: object = None) -> None:
        self._found: tuple[str, str, str] | None = None

    def detect_os(self, env: dict[str, str] | None = None) -> tuple[str, str, str]:
        """Return name, version and code name.

        Raises:
            OsNotDetected: the operating system is not known.
        """
        override = (os.environ if env is None else env).get("ROS_OS_OVERRIDE")
        if override:
            name, version, codename = (*override.split(":"), "", "")[:3]
            self._found = name, version, codename
        if self._found is None:
            self._found = _system()
        return self._found

    def get_name(self) -> str:
        """Return the name, such as ``debian``; raises OsNotDetected."""
        return self.detect_os()[0]

    def get_version(self) -> str:
        """Return the version, such as ``12``; raises OsNotDetected."""
        return self.detect_os()[1]

    def get_codename(self) -> str:
        """Return the code name, such as ``bookworm``; raises OsNotDetected."""
        return self.detect_os()[2]


def _system() -> tuple[str, str, str]:
    if sys.platform == "darwin":
        return OS_OSX, platform.mac_ver()[0], ""
    if sys.platform == "win32":
        return OS_WINDOWS, platform.version(), ""
    try:
        facts = platform.freedesktop_os_release()
    except OSError as error:
        raise OsNotDetected(f"Could not detect OS: {error}") from error
    return facts["ID"], facts.get("VERSION_ID", ""), facts.get("VERSION_CODENAME", "")
