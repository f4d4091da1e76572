"""Command lists of ``pyros1 pkg`` and ``pyros1 stack``."""

from __future__ import annotations

from pyros1.cli.usage import examples_text

_PACK = """USAGE: {program} <command> [options] [package]
  Allowed commands:
    help
    cflags-only-I     [--deps-only] [package]
    cflags-only-other [--deps-only] [package]
    depends           [package] (alias: deps)
    depends-indent    [package] (alias: deps-indent)
    depends-manifests [package] (alias: deps-manifests)
    depends-msgsrv    [package] (alias: deps-msgsrv)
    depends-on        [package]
    depends-on1       [package]
    depends-why --target=<target> [package] (alias: deps-why)
    depends1          [package] (alias: deps1)
    export [--deps-only] --lang=<lang> --attrib=<attrib> [package]
    find [package]
    langs
    libs-only-L     [--deps-only] [package]
    libs-only-l     [--deps-only] [package]
    libs-only-other [--deps-only] [package]
    list
    list-duplicates
    list-names
    plugins --attrib=<attrib> [--top=<toppkg>] [package]
    profile [--length=<length>] [--zombie-only]
    rosdep  [package] (alias: rosdeps)
    rosdep0 [package] (alias: rosdeps0)
    vcs  [package]
    vcs0 [package]
  Extra options:
    -q     Quiets error reports.

 If [package] is omitted, the current working directory
 is used (if it contains a package.xml or manifest.xml).
"""

_STACK = """USAGE: {program} [options] <command> [stack]
  Allowed commands:
    help
    find [stack]
    contents [stack]
    list
    list-names
    depends [stack] (alias: deps)
    depends-manifests [stack] (alias: deps-manifests)
    depends1 [stack] (alias: deps1)
    depends-indent [stack] (alias: deps-indent)
    depends-why --target=<target> [stack] (alias: deps-why)
    depends-on [stack]
    depends-on1 [stack]
    contains [package]
    contains-path [package]
    profile [--length=<length>]{end}

 If [stack] is omitted, the current working directory
 is used (if it contains a stack.xml).
"""

_MORE = """
  Also:
    create NAME [packages]         make a package
    cd|ls|edit|cat [package[/folder]] ...   its folder and files
    --json                         with list, list-names, depends and depends-on: print JSON
"""

_EXAMPLES = {
    "%prog create my_robot std_msgs": "make a package with nodes, a message and a launch file",
    "%prog find my_robot": "where it is",
    "%prog depends-why --target=std_msgs roscpp": "why one package needs another",
}


def usage(program: str, stock: str) -> str:
    """Return the command list.

    Args:
        program: how the user called the command.
        stock: ``rospack`` or ``rosstack``.
    """
    if stock == "rosstack":
        return _STACK.format(program=program, end=" ")  # stock has a space there
    text = _PACK.format(program=program)
    return text if program == stock else text + _MORE + examples_text(program, _EXAMPLES)
