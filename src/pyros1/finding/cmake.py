"""Writes the CMakeLists.txt of a new package, with the commented-out sections that the ROS tutorials ask users to fill
in.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import PurePosixPath

from pyros1.finding.new_package import NewPackage

_HEAD = """cmake_minimum_required(VERSION 3.0.2)
project({name})

# To build: catkin_make, in the folder above src. If a Python environment (venv, conda) is active, catkin does not find
# its own modules; in that case, use: catkin_make -DPYTHON_EXECUTABLE=/usr/bin/python3
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


_DEFINITION_FOLDERS = {
    "msg": ("add_message_files", "Message1.msg"),
    "srv": ("add_service_files", "Service1.srv"),
    "action": ("add_action_files", "Action1.action"),
}
"""Folder -> (the CMake function that lists its files, placeholder for a file name)."""


def has_definitions(files: Collection[str]) -> bool:
    """Return whether the files of a package include messages, services or actions."""
    return any(PurePosixPath(name).parts[0] in _DEFINITION_FOLDERS for name in files)


def cmake_lists(package: NewPackage, files: Collection[str]) -> str:
    """Return the text of CMakeLists.txt.

    Args:
        package: the new package.
        files: paths of its definitions, scripts and launch files, relative to the package.
    """
    head = _HEAD.format(name=package.name)
    if package.is_meta:
        return f"{head}\nfind_package(catkin REQUIRED)\ncatkin_metapackage()\n"
    depends = sorted({*package.depends} - {"catkin", "message_generation", "message_runtime"})
    has_messages = has_definitions(files)
    return "\n".join(
        [
            head,
            _find_package_block(package, [*depends, *(["message_generation"] if has_messages else [])]),
            _definitions_block(depends, files),
            _catkin_package_block(depends, has_messages),
            _include_directories_block(depends),
            _PROGRAMS,
            _install_block(files),
        ]
    )


def _files_in(folder: str, files: Collection[str]) -> list[str]:
    """Return the names of the files in one of the package's folders, sorted."""
    return sorted(PurePosixPath(name).name for name in files if PurePosixPath(name).parts[0] == folder)


def _cmake_call(function: str, *lines: str) -> str:
    """Return a CMake call with one argument per line."""
    return "\n".join([f"{function}(", *(f"  {line}" for line in lines), ")", ""])


def _comment_out(text: str) -> str:
    return "".join(f"# {line}\n" for line in text.splitlines())


def _find_package_block(package: NewPackage, components: Sequence[str]) -> str:
    text = "# Dependencies of this package\n"
    text += (
        _cmake_call("find_package", "catkin REQUIRED COMPONENTS", *components).replace("(\n  ", "(", 1)
        if components
        else "find_package(catkin REQUIRED)\n"
    )
    text += "".join(f"find_package({key} REQUIRED)\n" for key in package.system_depends)
    boost = f"find_package(Boost REQUIRED COMPONENTS {' '.join(package.boost or ['system'])})\n"
    return text + (boost if package.boost else _comment_out(boost))


def _definitions_block(depends: Sequence[str], files: Collection[str]) -> str:
    text = _DEFINITIONS
    for folder, (function, placeholder) in _DEFINITION_FOLDERS.items():
        existing_files = _files_in(folder, files)
        call = _cmake_call(function, "FILES", *(existing_files or [placeholder]))
        text += call if existing_files else _comment_out(call)
    text += "# After DEPENDENCIES: the packages whose message types are used in the definitions above\n"
    message_packages = [name for name in depends if name.endswith("_msgs")] or ["std_msgs"]
    if _files_in("action", files):
        text += _cmake_call("generate_messages", "DEPENDENCIES", *message_packages)
    elif has_definitions(files):
        text += _cmake_call("generate_messages", *(f"# {word}" for word in ["DEPENDENCIES", *message_packages]))
    else:
        text += _comment_out(_cmake_call("generate_messages", "DEPENDENCIES", *message_packages))
    cfg_files = [f"cfg/{name}" for name in _files_in("cfg", files)]
    options_call = _cmake_call("generate_dynamic_reconfigure_options", *(cfg_files or ["cfg/Settings1.cfg"]))
    return f"{text}# Settings for dynamic_reconfigure\n{options_call if cfg_files else _comment_out(options_call)}"


def _catkin_package_block(depends: Sequence[str], has_messages: bool) -> str:
    lines = ["# INCLUDE_DIRS include", "# LIBRARIES ${PROJECT_NAME}"]
    exported = [*depends, *(["message_runtime"] if has_messages else [])]
    lines.append(f"{'' if exported else '# '}CATKIN_DEPENDS{''.join(f' {name}' for name in exported)}")
    lines += [] if has_messages else ["# message_runtime"]
    return "# What this package exports to packages that depend on it\n" + _cmake_call("catkin_package", *lines)


def _include_directories_block(depends: Sequence[str]) -> str:
    text = _cmake_call("include_directories", "# include", "${catkin_INCLUDE_DIRS}")
    return text if "roscpp" in depends else _comment_out(text)


def _install_block(files: Collection[str]) -> str:
    programs = _files_in("scripts", files)
    scripts_call = _cmake_call(
        "catkin_install_python",
        "PROGRAMS",
        *(f"scripts/{name}" for name in programs or ["my_node"]),
        "DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION}",
    )
    folders = [folder for folder in ("config", "launch", "urdf") if _files_in(folder, files)]
    folders_call = (
        f"install(DIRECTORY {' '.join(folders or ['launch'])} DESTINATION ${{CATKIN_PACKAGE_SHARE_DESTINATION}})\n"
    )
    targets = "install(TARGETS ${PROJECT_NAME}_node RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})\n"
    text = "# What `catkin_make install` installs\n"
    text += scripts_call if programs else _comment_out(scripts_call)
    text += folders_call if folders else _comment_out(folders_call)
    return text + _comment_out(targets)
