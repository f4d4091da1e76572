"""The CMakeLists.txt of a new package, with the commented-out sections that ROS's tutorials ask people to fill in."""

from __future__ import annotations

from collections.abc import Sequence

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


def cmake_lists(package: NewPackage, has_messages: bool) -> str:
    """Return the text of CMakeLists.txt.

    Args:
        package: the new package.
        has_messages: whether it has the example's message and nodes.
    """
    head = _HEAD.format(name=package.name)
    if package.meta:
        return f"{head}\nfind_package(catkin REQUIRED)\ncatkin_metapackage()\n"
    depends = sorted({*package.depends} - {"catkin", "message_generation", "message_runtime"})
    return "\n".join(
        [
            head,
            _found(package, [*depends, *(["message_generation"] if has_messages else [])]),
            _definitions(depends, has_messages),
            _exported(depends, has_messages),
            _included(depends),
            _PROGRAMS,
            _installed(has_messages),
        ]
    )


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


def _definitions(depends: Sequence[str], has_messages: bool) -> str:
    messages = _call("add_message_files", "FILES", "Measurement.msg" if has_messages else "Message1.msg")
    text = _DEFINITIONS + (messages if has_messages else _commented(messages))
    text += _commented(_call("add_service_files", "FILES", "Service1.srv"))
    text += _commented(_call("add_action_files", "FILES", "Action1.action"))
    text += "# After DEPENDENCIES: the packages whose messages are fields of yours\n"
    fields = [each for each in depends if each.endswith("_msgs")] or ["std_msgs"]
    if has_messages:
        return f"{text}generate_messages(\n  # DEPENDENCIES\n" + "".join(f"  # {each}\n" for each in fields) + ")\n"
    text += _commented(_call("generate_messages", "DEPENDENCIES", *fields))
    options = _call("generate_dynamic_reconfigure_options", "cfg/Settings1.cfg")
    return f"{text}# Settings for dynamic_reconfigure\n{_commented(options)}"


def _exported(depends: Sequence[str], has_messages: bool) -> str:
    lines = ["# INCLUDE_DIRS include", "# LIBRARIES ${PROJECT_NAME}"]
    exported = [*depends, *(["message_runtime"] if has_messages else [])]
    lines.append(f"{'' if exported else '# '}CATKIN_DEPENDS{''.join(f' {each}' for each in exported)}")
    lines += [] if has_messages else ["# message_runtime"]
    return "# What this package exports to packages that depend on it\n" + _call("catkin_package", *lines)


def _included(depends: Sequence[str]) -> str:
    text = _call("include_directories", "# include", "${catkin_INCLUDE_DIRS}")
    return text if "roscpp" in depends else _commented(text)


def _installed(has_messages: bool) -> str:
    programs = ["minimal_publisher", "minimal_subscriber"] if has_messages else ["my_node"]
    scripts = _call(
        "catkin_install_python",
        "PROGRAMS",
        *(f"scripts/{name}" for name in programs),
        "DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION}",
    )
    launch = "install(DIRECTORY launch DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})\n"
    targets = "install(TARGETS ${PROJECT_NAME}_node RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})\n"
    text = "# What `catkin_make install` installs\n" + (
        scripts + launch if has_messages else _commented(scripts + launch)
    )
    return text + _commented(targets)
