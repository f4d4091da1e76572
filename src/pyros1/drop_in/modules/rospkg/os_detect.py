"""Name and version of the operating system, from /etc/os-release."""

from __future__ import annotations

import os
import platform

from pyros1.drop_in.missing import missing

_WHY = "`pip install rospkg` provides it"
OS_DEBIAN, OS_UBUNTU = "debian", "ubuntu"
__getattr__ = missing(__name__, OsDetector=_WHY, uname_get_machine=_WHY)


class OsNotDetected(Exception):
    """The operating system is not known."""


class OsDetect:
    """The operating system; ``ROS_OS_OVERRIDE``, as ``name:version:codename``, has priority."""

    def detect_os(self) -> tuple[str, str, str]:
        """Return name, version and code name, such as ``debian``, ``12`` and ``bookworm``; raises OsNotDetected."""
        override = os.environ.get("ROS_OS_OVERRIDE")
        if override:
            name, version, codename = (*override.split(":"), "", "")[:3]
            return name, version, codename
        try:
            facts = platform.freedesktop_os_release()
        except OSError as error:
            raise OsNotDetected(f"Could not detect OS: {error}") from error
        return facts["ID"], facts.get("VERSION_ID", ""), facts.get("VERSION_CODENAME", "")

    def get_name(self) -> str:
        """Return the name; raises OsNotDetected."""
        return self.detect_os()[0]

    def get_version(self) -> str:
        """Return the version; raises OsNotDetected."""
        return self.detect_os()[1]

    def get_codename(self) -> str:
        """Return the code name; raises OsNotDetected."""
        return self.detect_os()[2]
