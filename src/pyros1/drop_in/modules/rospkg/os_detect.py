"""Name and version of the operating system, from /etc/os-release."""

from __future__ import annotations

import os
import platform

from pyros1.drop_in.module_attributes import module_getattr

_REASON = "`pip install rospkg` provides it"
OS_DEBIAN, OS_UBUNTU = "debian", "ubuntu"
__getattr__ = module_getattr(__name__, OsDetector=_REASON, uname_get_machine=_REASON)


class OsNotDetected(Exception):
    """The operating system is not known."""


class OsDetect:
    """The operating system; ``ROS_OS_OVERRIDE=name:version:codename`` takes precedence."""

    def detect_os(self) -> tuple[str, str, str]:
        """Return name, version and code name, such as ``debian``, ``12`` and ``bookworm``; raises OsNotDetected."""
        override = os.environ.get("ROS_OS_OVERRIDE")
        if override:
            name, version, codename = (*override.split(":"), "", "")[:3]
            return name, version, codename
        try:
            release = platform.freedesktop_os_release()
        except OSError as error:
            raise OsNotDetected(f"Could not detect OS: {error}") from error
        return release["ID"], release.get("VERSION_ID", ""), release.get("VERSION_CODENAME", "")

    def get_name(self) -> str:
        """Return the name; raises OsNotDetected."""
        return self.detect_os()[0]

    def get_version(self) -> str:
        """Return the version; raises OsNotDetected."""
        return self.detect_os()[1]

    def get_codename(self) -> str:
        """Return the code name; raises OsNotDetected."""
        return self.detect_os()[2]
