"""Creates new packages that work with pyros1 and with stock catkin."""

from __future__ import annotations

import keyword
import os
import re
from collections.abc import Collection
from contextlib import suppress
from html import escape  # also escapes for XML; xml.sax is slow to import
from pathlib import Path

from pyros1.finding.cmake import cmake_lists, has_definitions
from pyros1.finding.new_package import NewPackage
from pyros1.ground.errors import Error

TEMPLATES_FOLDER = Path(__file__).resolve().parent / "templates"
_NAME_PATTERN = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
_PERSON_PATTERN = re.compile(r"(.*?)\s*<([^<>]+@[^<>]+)>")


class CreateError(Error):
    """The package cannot be created."""


def package_name_problem(name: str) -> str:
    """Return the problem with a package name (REP 144), or an empty string if it is valid."""
    if not name:
        return "it is empty"
    if name[0].isdigit() or name[0] in "_-":
        return "it must start with a letter"
    if not _NAME_PATTERN.fullmatch(name) or len(name) < 2:
        return (
            "use only lower-case letters, digits and single underscores, two characters or more, for example my_robot"
        )
    if keyword.iskeyword(name):
        return "it is a Python keyword, so nothing could be imported from it"
    return ""


def create_package(package: NewPackage, parent: Path) -> list[str]:
    """Write a package.

    Args:
        package: the new package.
        parent: the folder in which the package is created.

    Returns:
        The paths of the new files and folders relative to ``parent``, in order; folders have a trailing slash.

    Raises:
        CreateError: the name or version is not valid; a file already exists; or a file cannot be written. No part of
            the package is left then.
    """
    if not re.fullmatch(r"[^\W]([\w-]*)", package.name):
        raise CreateError(f"'{package.name}' is not a valid package name: {package_name_problem(package.name)}")
    if not re.fullmatch(r"\d+\.\d+\.\d+", package.version):
        raise CreateError(f"'{package.version}' is not a valid version: use three numbers, for example 0.1.0")
    folder = parent / package.name
    files = _package_files(package)
    for path in [folder, *(folder / name for name in files)]:
        if path.exists() and (path != folder or not path.is_dir()):
            raise CreateError(f"{path} already exists; nothing was changed")
    created = []
    new_paths: list[Path] = []
    path = folder
    try:
        for name, text in files.items():
            path = folder / name
            _make_folder(path.parent, new_paths)
            new_paths.append(path)
            path.write_text(text, encoding="utf-8")
            if text.startswith("#!") or name.startswith("scripts/"):
                path.chmod(0o755)
            created.append(f"{package.name}/{name}")
        for name in _empty_folders(package):
            path = folder / name
            _make_folder(path, new_paths)
            created.append(f"{package.name}/{name}/")
    except OSError as error:
        for new_path in reversed(new_paths):  # otherwise a part of the package would block the next try
            with suppress(OSError):
                (new_path.rmdir if new_path.is_dir() else new_path.unlink)()
        raise CreateError(f"cannot write {error.filename or path}: {error.strerror}") from error
    return created


def _make_folder(folder: Path, new_paths: list[Path]) -> None:
    """Make a folder and those above it, and append the new ones to a list."""
    for path in reversed([folder, *folder.parents]):
        if not path.is_dir():
            path.mkdir()
            new_paths.append(path)


def _empty_folders(package: NewPackage) -> list[str]:
    if package.is_meta or package.examples or package.files:
        return []
    return [
        *([f"include/{package.name}"] if "roscpp" in package.depends else []),
        *(["src"] if {"roscpp", "rospy"} & {*package.depends} else []),
    ]


def _package_files(package: NewPackage) -> dict[str, str]:
    content_files = _content_files(package)
    return {
        "package.xml": package_xml(package, content_files),
        "CMakeLists.txt": cmake_lists(package, content_files),
        **content_files,
    }


def _content_files(package: NewPackage) -> dict[str, str]:
    """Return path -> text of all files other than package.xml and CMakeLists.txt."""
    if package.is_meta:
        return {}
    files = {}
    if package.examples:
        for base, _, names in os.walk(TEMPLATES_FOLDER):
            for name in sorted(names):
                path = Path(base, name)
                text = path.read_text(encoding="utf-8")
                text = text.replace("@NAME@", package.name).replace("@DESCRIPTION@", _description(package))
                files[path.relative_to(TEMPLATES_FOLDER).as_posix()] = text
    return {**files, **package.files}


def _description(package: NewPackage) -> str:
    return package.description or f"The {package.name} package"


def package_xml(package: NewPackage, files: Collection[str]) -> str:
    """Return the text of package.xml in format 2.

    Args:
        package: the new package.
        files: paths of its files, relative to the package.
    """
    has_messages = has_definitions(files)
    lines = ['<?xml version="1.0"?>', '<package format="2">', f"  <name>{package.name}</name>"]
    lines += [
        f"  <version>{package.version}</version>",
        f"  <description>{escape(_description(package))}</description>",
    ]
    user = os.environ.get("USER") or "user"
    lines += [
        "",
        *(_person_tag("maintainer", person) for person in package.maintainers or [f"{user} <{user}@todo.todo>"]),
    ]
    lines += [_person_tag("author", person) for person in package.authors]
    lines += [f"  <license>{escape(license_name)}</license>" for license_name in package.licenses or ["TODO"]]
    lines += [f'  <!-- <url type="website">http://wiki.ros.org/{package.name}</url> -->']
    lines += ["", "  <buildtool_depend>catkin</buildtool_depend>"]
    if package.is_meta:
        lines += [f"  <exec_depend>{escape(name)}</exec_depend>" for name in sorted(package.depends)]
        lines += ["", "  <export>", "    <metapackage/>", "  </export>"]
    else:
        depends = _dependency_names(package, has_messages)
        lines += [f"  <depend>{escape(name)}</depend>" for name in depends]
        lines += [
            f"  <exec_depend>{escape(name)}</exec_depend>" for name in sorted({*package.run_depends} - {*depends})
        ]
        if has_messages:
            lines += ["  <build_depend>message_generation</build_depend>"]
            lines += [f"  <{tag}>message_runtime</{tag}>" for tag in ("build_export_depend", "exec_depend")]
        else:
            lines += ["  <!-- A package with messages, services or actions also needs: -->"]
            lines += ["  <!-- <build_depend>message_generation</build_depend> -->"]
            lines += ["  <!-- <exec_depend>message_runtime</exec_depend> -->"]
    return "\n".join([*lines, "</package>", ""])


def _dependency_names(package: NewPackage, has_messages: bool) -> list[str]:
    generated = {"message_generation", "message_runtime"} if has_messages else set()
    return sorted({*package.depends, *package.system_depends, *(["boost"] if package.boost else [])} - generated)


def _person_tag(tag: str, person: str) -> str:
    match = _PERSON_PATTERN.fullmatch(person)
    if match:
        return f'  <{tag} email="{escape(match[2])}">{escape(match[1] or match[2])}</{tag}>'
    email_attribute = (
        f' email="{re.sub(r"[^a-z0-9.]+", ".", person.lower()) or "user"}@todo.todo"' if tag == "maintainer" else ""
    )
    return f"  <{tag}{email_attribute}>{escape(person)}</{tag}>"
