"""Manifests, and other XML files of packages, that cannot be read: their readers say so."""

from __future__ import annotations

from pathlib import Path

import pytest

from pyros1.doctor.local_facts import check_packages
from pyros1.finding.manifest import ManifestError, read_manifest
from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.depends import declared_depends
from pyros1.launch.testing.junit import read_results

UNKNOWN = b"<?xml version='1.0' encoding='klingon'?><package><name>p</name></package>"


@pytest.mark.parametrize(
    "content", [UNKNOWN, b"", b"<", b"<!DOCTYPE a [<!ENTITY b 'c'>]><package>&b;</package>", b"\0"]
)
def test_what_is_no_xml_is_said(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "p" / "package.xml"
    path.parent.mkdir()
    path.write_bytes(content)
    with pytest.raises(ManifestError, match=r"package\.xml is not valid XML: "):
        read_manifest(path)
    with pytest.raises(LaunchError, match=r"cannot read .*package\.xml: "):
        declared_depends(path.parent)
    assert read_results(path, "x").unreadable
    path.write_bytes(content.replace(b"<package>", b"<package><name>p</name>"))
    problems = check_packages({"ROS_PACKAGE_PATH": str(tmp_path)})
    assert all(str(path) in each for each in problems if str(tmp_path) in each)
