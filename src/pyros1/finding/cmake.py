"""The CMakeLists.txt of a new package, with the commented-out sections that ROS's tutorials ask people to fill in."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import PurePosixPath

from pyros1.finding.new_package import NewPackage

_HEAD = """cmake_minimum_required(VERSION 3.0.2)
project({name})

# To build: catkin_make, in the folder above src. In a shell with a Python environment (venv, conda) catkin does not
# find its own modules; then use: catkin_make -DPYTHON_EXECUTABLE=/usr/bin/python3
"""

_DEFINITIONS = """# Messages, services and actions: the files in the folders msg, srv and action.
# To add your own, remove the # and name your files; then add message_generation to find_package above,
# message_runtime to catkin_package below, and both to package.xml.
"""

_PROGRAMS = """# Programs and libraries in C++
# add_library(${PROJECT_NAME} src/${PROJECT_NAME}.cpp)
# add_executable(${PROJECT_NAME}_node src/${PROJECT_NAME}_node.cpp)
# target_link_libraries(${PROJECT_NAME}_node ${catkin_LIBRARIES})
# This makes catkin generate messages before it compiles the program:
# add_dependencies(${PROJECT_NAME}_node ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
"""


_DEFINED = {
    "msg": ("add_message_files", "Message1.msg"),
    "srv": ("add_service_files", "Service1.srv"),
    "action": ("add_action_files", "Action1.action"),
}
"""Folder -> the call that names its files, and the placeholder to be filled in."""


def has_definitions(files: Collection[str]) -> bool:
    """Return whether there are messages, services or actions among the files of a package."""
    return any(PurePosixPath(name).parts[0] in _DEFINED for name in files)


def cmake_lists(package: NewPackage, files: Collection[str]) -> str:
    """Return the text of CMakeLists.txt.

    Args:
        package: the new package.
        files: the paths in it of its definitions, scripts and launch files.
    """
    head = _HEAD.format(name=package.name)
    if package.meta:
        return f"{head}\nfind_package(catkin REQUIRED)\ncatkin_metapackage()\n"
    depends = sorted({*package.depends} - {"catkin", "message_generation", "message_runtime"})
    defines = has_definitions(files)
    return "\n".join(
        [
            head,
            _found(package, [*depends, *(["message_generation"] if defines else [])]),
            _definitions(depends, files),
            _exported(depends, defines),
            _included(depends),
            _PROGRAMS,
            _installed(files),
        ]
    )


def _within(folder: str, files: Collection[str]) -> list[str]:
    """Return the files of a folder, without its name."""
    return sorted(PurePosixPath(name).name for name in files if PurePosixPath(name).parts[0] == folder)


def _call(function: str, *lines: str) -> str:
    """Return a CMake call with one argument per line."""
    return "\n".join([f"{function}(", *(f"  {line}" for line in lines), ")", ""])


def _commented(text: str) -> str:
    return "".join(f"# {line}\n" for line in text.splitlines())


def _found(package: NewPackage, components: Sequence[str]) -> str:
    text = "# Dependencies of this package\n"
    text += (
        _call("find_package", "catkin REQUIRED COMPONENTS", *components).replace("(\n  ", "(", 1)
        if components
        else "find_package(catkin REQUIRED)\n"
    )
    text += "".join(f"find_package({each} REQUIRED)\n" for each in package.system)
    boost = f"find_package(Boost REQUIRED COMPONENTS {' '.join(package.boost or ['system'])})\n"
    return text + (boost if package.boost else _commented(boost))


def _definitions(depends: Sequence[str], files: Collection[str]) -> str:
    text = _DEFINITIONS
    for folder, (function, default_file) in _DEFINED.items():
        existing_files = _within(folder, files)
        call = _call(function, "FILES", *(existing_files or [default_file]))
        text += call if existing_files else _commented(call)
    text += "# After DEPENDENCIES: the packages whose messages are fields of yours\n"
    fields = [each for each in depends if each.endswith("_msgs")] or ["std_msgs"]
    if _within("action", files):
        text += _call("generate_messages", "DEPENDENCIES", *fields)
    elif has_definitions(files):
        text += _call("generate_messages", *(f"# {each}" for each in ["DEPENDENCIES", *fields]))
    else:
        text += _commented(_call("generate_messages", "DEPENDENCIES", *fields))
    settings = [f"cfg/{name}" for name in _within("cfg", files)]
    options = _call("generate_dynamic_reconfigure_options", *(settings or ["cfg/Settings1.cfg"]))
    return f"{text}# Settings for dynamic_reconfigure\n{options if settings else _commented(options)}"


def _exported(depends: Sequence[str], has_messages: bool) -> str:
    lines = ["# INCLUDE_DIRS include", "# LIBRARIES ${PROJECT_NAME}"]
    exported = [*depends, *(["message_runtime"] if has_messages else [])]
    lines.append(f"{'' if exported else '# '}CATKIN_DEPENDS{''.join(f' {each}' for each in exported)}")
    lines += [] if has_messages else ["# message_runtime"]
    return "# What this package exports to packages that depend on it\n" + _call("catkin_package", *lines)


def _included(depends: Sequence[str]) -> str:
    text = _call("include_directories", "# include", "${catkin_INCLUDE_DIRS}")
    return text if "roscpp" in depends else _commented(text)


def _installed(files: Collection[str]) -> str:
    programs = _within("scripts", files)
    scripts = _call(
        "catkin_install_python",
        "PROGRAMS",
        *(f"scripts/{name}" for name in programs or ["my_node"]),
        "DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION}",
    )
    folders = [folder for folder in ("config", "launch", "urdf") if _within(folder, files)]
    others = f"install(DIRECTORY {' '.join(folders or ['launch'])} DESTINATION ${{CATKIN_PACKAGE_SHARE_DESTINATION}})\n"
    targets = "install(TARGETS ${PROJECT_NAME}_node RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})\n"
    text = "# What `catkin_make install` installs\n"
    text += scripts if programs else _commented(scripts)
    text += others if folders else _commented(others)
    return text + _commented(targets)
