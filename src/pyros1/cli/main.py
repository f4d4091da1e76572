"""The ``pyros1`` command: finds the module of the command that was asked for, and imports no other."""

from __future__ import annotations

import os
import sys
from importlib import import_module

from pyros1 import interrupts
from pyros1.cli import output
from pyros1.cli.clean_output import clean_output
from pyros1.cli.pkg_here import add_packages_here
from pyros1.errors import Error

COMMANDS = {
    "core": ("core", "start a master, with parameter server and rosout"),
    "master": ("master", "start a master alone, without rosout"),
    "launch": ("launch", "start the nodes of a launch file"),
    "test": ("test", "run the tests of a launch file"),
    "run": ("run", "start a node of a package"),
    "topic": ("topic", "show and use topics: list echo hz bw delay info type find pub"),
    "node": ("node_cmd", "show and end nodes: list info ping machine kill cleanup"),
    "service": ("service", "show and call services: list info type uri node args find call"),
    "param": ("param", "show and set parameters: list get set load dump delete"),
    "msg": ("msg", "show message types: show list md5 package packages"),
    "srv": ("srv", "show service types: show list md5 package packages"),
    "wtf": ("wtf", "find what is wrong with this machine and the running system, and the cure"),
    "doctor": ("wtf", "the same as wtf"),
    "log": ("log", "show and set log levels, print log messages: list get set echo"),
    "graph": ("graph_cmd", "print nodes and their connections"),
    "clean": ("clean", "show and remove log files: check purge"),
    "version": ("version", "print versions of packages and the name of the distribution"),
    "pkg": ("pkg", "find and make packages: create find list depends depends-on depends-why export plugins ..."),
    "stack": ("pkg_stack", "find stacks: find list contents contains depends"),
    "setup": ("setup", "for shells: source <(pyros1 setup) gives the stock names and completion"),
    "unsetup": ("setup_undo", "take back what setup did to this shell"),
    "topic_tools": ("topic_tools", "forward topics: relay drop throttle mux demux transform relay_field"),
    "tf": ("tf", "show and publish coordinate frames: echo monitor tree view_frames static_transform_publisher"),
    "dynparam": ("dynparam", "show and change parameters of running nodes: list get set set_from_parameters load dump"),
    "diagnostic": ("diagnostic", "show what the robot's parts say of their state"),
    "unit": ("unit", "run one test program"),
    "msg-proto": ("msg_proto", "print a message or service request to fill in"),
    "bag": ("bag", "record, play, look at and change bags: info reindex filter compress merge ..."),
}
"""Command -> module in pyros1.cli, and what it does."""
CALLED_OTHERWISE = {"rosconsole": "log", "rospack": "pkg", "rosstack": "stack"}
"""Stock name -> command, where that is not what follows ``ros``."""


_SPEAK_FOR_THEMSELVES = frozenset({"run", "launch"})
"""Modules of commands that give hints at misspelt words themselves."""
_TAKE_VALUES = frozenset({"pub", "call", "set", "publish"})
"""Verbs whose words are YAML values, in which ``a:1`` and ``a=1`` say something."""


def usage() -> str:
    """The text of ``pyros1 help``."""
    lines = ["usage: pyros1 <command> [arguments]", "", "Commands:"]
    lines += [f"  {name:11} {about}" for name, (_, about) in COMMANDS.items()]
    lines += ["", "Each takes the arguments of the ROS 1 tool of that name: `pyros1 topic list` is `rostopic list`."]
    lines += ["Type pyros1 <command> -h for more. pyros1 --version shows the version."]
    return "\n".join(lines)


def command_name(word: str) -> str | None:
    """The command that a word means: ``topic`` or, by its stock name, ``rostopic``. None if there is none."""
    if word in COMMANDS:
        return word
    if word in CALLED_OTHERWISE:
        return CALLED_OTHERWISE[word]
    return word[3:] if word.startswith("ros") and word[3:] in COMMANDS else None


def entry(argv: list[str] | None = None, *, alone: bool | None = None) -> int:
    """Run a command.

    Ctrl-C ends what runs until then with 0. It ends what is cut short by it as if there were no handler: a loop of the
    shell around it ends, too.

    Args:
        argv: the command line with the program's name; None takes ``sys.argv``. Under a stock tool's name, such as
            ``rostopic``, the program is that tool.
        alone: this process is the command and nothing else; None: it is if there is no ``argv``.

    Returns:
        The exit code.
    """
    if alone is None:
        alone = argv is None
    if alone:
        interrupts.die_quietly()  # a traceback of imports is of no use
        output.prepare()
    try:
        try:
            with clean_output():
                return _entry(list(sys.argv if argv is None else argv))
        finally:
            sys.stdout.flush()  # now: what fails in Python's own flush at the end cannot be caught
    except KeyboardInterrupt:
        if alone:
            interrupts.die()
        return interrupts.INTERRUPTED
    except BrokenPipeError:
        output.abandon()  # whoever read it has gone
        return 0
    except OSError as error:
        if error.filename != output.NAME:
            raise
        output.abandon()
        print(f"ERROR: cannot write to standard output: {error.strerror}", file=sys.stderr)
        return 1


def _entry(words: list[str]) -> int:
    called = os.path.basename(words[0]) if words else ""
    if called.startswith("ros") and command_name(called):
        words[:1] = ["pyros1", called]
    if len(words) < 2:
        print(usage())
        return 64
    word = words[1]
    if word in ("-h", "--help", "help"):
        print(usage())
        return 0
    if word in ("--version", "-V"):
        from pyros1 import __version__  # noqa: PLC0415

        print(f"pyros1 {__version__}")
        return 0
    if word == "__complete":
        return _run("complete", words[2:])
    name = command_name(word)
    if name is None:
        from pyros1.cli.common import elsewhere  # noqa: PLC0415 - only what fails needs it
        from pyros1.suggest import did_you_mean  # noqa: PLC0415

        hint = elsewhere(word) or did_you_mean(word, COMMANDS)
        print(f"pyros1: there is no command {word!r}{hint}; see: pyros1 help", file=sys.stderr)
        return 64
    return _run(COMMANDS[name][0], words[2:])


def _run(module: str, arguments: list[str]) -> int:
    try:
        add_packages_here(os.environ)
        main = import_module(f"pyros1.cli.{module}").main
        with interrupts.raised():
            code: int = main(arguments)
        if code:
            _say_what_was_meant(module, arguments)
        return code
    except SystemExit as end:
        if end.code:  # a wrong command line
            _say_what_was_meant(module, arguments)
        raise
    except Error as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    except MemoryError:
        print("ERROR: there is not enough memory for this", file=sys.stderr)
        return 1
    except UnicodeDecodeError as error:
        byte, place = error.object[error.start], error.start
        print(f"ERROR: what was read is not UTF-8 text: byte {byte:#04x} at {place}", file=sys.stderr)
        return 1
    except OSError as error:
        if error.filename in (None, output.NAME):  # a defect, if it is about no file that the user named
            raise
        print(f"ERROR: {error.filename or repr('')}: {error.strerror}", file=sys.stderr)
        return 1


def _say_what_was_meant(module: str, arguments: list[str]) -> None:
    """After a failure: give hints at words that look like misspelt options and remappings, but for messages' values."""
    if module in _SPEAK_FOR_THEMSELVES:
        return
    from pyros1.suggest import argument_hint, meant_option  # noqa: PLC0415 - only what fails needs it

    values = any(verb in arguments for verb in _TAKE_VALUES)
    for word in arguments:
        may_be_a_value = (values and word[:1] != "_") or os.path.exists(word)
        hint = argument_hint(word) if meant_option(word) or not may_be_a_value else ""
        if hint:
            print(hint, file=sys.stderr)
