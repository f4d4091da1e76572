"""Verbs and kinds of arguments of all commands, for completion."""

from __future__ import annotations

# Kinds of the arguments in order; the last is repeated if it ends with "+". Several kinds are parted by "|".
_TOPICS = ("topic+",)
_NODES = ("node+",)
_PLACES = ("package|place",)

VERBS: dict[str, dict[str, tuple[str, ...]]] = {
    "topic": {
        "bw": _TOPICS,
        "delay": ("topic",),
        "echo": _TOPICS,
        "find": ("message",),
        "hz": _TOPICS,
        "info": ("topic",),
        "list": ("namespace",),
        "plot": _TOPICS,
        "pub": ("topic", "topic_type", "message_text"),
        "type": ("topic",),
    },
    "pkg": {
        **dict.fromkeys((
                "cflags-only-I", "cflags-only-other", "depends", "depends-indent", "depends-manifests",
                "depends-msgsrv", "depends-on", "depends-on1", "depends-why", "depends1", "export", "find",
                "libs-only-L", "libs-only-l", "libs-only-other", "plugins", "rosdep", "rosdep0", "vcs", "vcs0",
            ), ("package",)),
        **dict.fromkeys(("help", "langs", "list", "list-duplicates", "list-names", "profile"), ()),
        "create": ("", "package+"),
        "cat": ("package", "package_file"),
        "cd": _PLACES,
        "cp": ("package", "package_file", "file"),
        "edit": ("package", "package_file"),
        "ls": _PLACES,
        "mv": ("package", "package_file", "file"),
    },
    "stack": {
        **dict.fromkeys(("contains", "contains-path", "contents", "depends", "depends1", "find"), ("package",)),
        **dict.fromkeys(("depends-on", "depends-on1", "depends-why", "depends-indent"), ("package",)),
        **dict.fromkeys(("help", "list", "list-names", "profile"), ()),
    },
    "clean": {"check": (), "purge": (),
    },
}  # fmt: skip
"""Command -> verb -> kinds of its arguments."""

_PLAIN: dict[str, tuple[str, ...]] = {
    "run": ("package", "executable", "file+"),
    "launch": ("package|launch_file", "package_launch_file|launch_arg", "launch_arg+"),
    "test": ("package|launch_file", "package_launch_file|launch_arg", "launch_arg+"),
    "unit": ("file+",),
    "wtf": ("launch_file",),
    "doctor": ("launch_file",),
    "version": ("package",),
}


def arguments_of(command: str, verb: str, position: int) -> str:
    """Return the kinds of an argument, parted by ``|``; empty if nothing is known.

    Args:
        command: the command.
        verb: its verb, empty if it has none.
        position: number of arguments before this one.
    """
    kinds = VERBS.get(command, {}).get(verb, ()) if verb else _PLAIN.get(command, ())
    if position < len(kinds):
        return kinds[position].rstrip("+")
    return kinds[-1].rstrip("+") if kinds and kinds[-1].endswith("+") else ""
