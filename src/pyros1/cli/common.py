"""What all commands share: their arguments, names, the master, and how errors end them.

Only what every command needs is imported here: listing topics must stay quick.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

from pyros1 import names, shown
from pyros1.cli import output
from pyros1.errors import Error, MasterUnreachableError

if TYPE_CHECKING:
    from optparse import HelpFormatter, OptionParser

    from pyros1.graph import Graph
    from pyros1.net.master_client import MasterClient
    from pyros1.node import Node

MASTER_TIMEOUT = 5.0
"""Seconds that a command gives the master for an answer."""
EX_USAGE = 64
"""Exit code of a missing or unknown subcommand (sysexits.h), as the stock tools'."""


class CommandError(Error):
    """Ends a command with a text and an exit code.

    Args:
        text: printed to stderr as it is, without "ERROR: " before it if ``plain``.
    """

    def __init__(self, text: str, code: int = 1, *, plain: bool = False) -> None:
        self.code = code
        self.plain = plain
        super().__init__(text)


def program_name(stock: str) -> str:
    """How the user called this command: ``rostopic`` under that name, else ``pyros1 topic``."""
    called = os.path.basename(sys.argv[0]) if sys.argv else ""
    return (
        stock if called == stock else "pyros1 log" if stock == "rosconsole" else f"pyros1 {stock.removeprefix('ros')}"
    )


class Invocation:
    """One run of a command: its arguments without the remappings, and the names and the master that those give (N11).

    Args:
        stock: the stock tool's name, for example ``rostopic``.
        argv: arguments after the command's name, subcommand first.
        environ: environment variables; None takes the process's.
    """

    def __init__(self, stock: str, argv: list[str], environ: Mapping[str, str] | None = None) -> None:
        self.environ = os.environ if environ is None else environ
        arguments = names.parse_arguments(argv)
        self.stock = stock
        self.program = program_name(stock)
        self.verb = arguments.rest[0] if arguments.rest else ""
        self.args = arguments.rest[1:]
        self.special = arguments.special
        self.remapping_args = [arg for arg in argv if arg not in arguments.rest]
        ns = arguments.special.get("__ns") or self.environ.get("ROS_NAMESPACE") or names.SEP
        self._namespace = names.SEP + ns.strip(names.SEP)
        self._master: MasterClient | None = None
        self._wait: Callable[[float], bool]  # set by open_node

    def resolve(self, name: str) -> str:
        """Return the full name that a name on the command line stands for. Legal or not is the master's business."""
        if names.is_private(name):
            return shown.foreign(names.canonicalize_name(f"{self._namespace}/{self.stock}/{name[1:]}"))
        return shown.foreign(names.canonicalize_name(names.ns_join(self._namespace, name)))

    @property
    def namespace(self) -> str:
        """The namespace of relative names, ``/`` if none was given."""
        return self._namespace

    @property
    def caller_id(self) -> str:
        """The name under which the tool speaks to master and nodes."""
        return f"/{self.stock}-{os.getpid()}" if self.stock == "rosparam" else f"/{self.stock}"

    @property
    def master(self) -> MasterClient:
        """The master of this system."""
        if self._master is None:
            from pyros1.net.hosts import master_uri  # noqa: PLC0415
            from pyros1.net.master_client import MasterClient  # noqa: PLC0415

            uri = master_uri(self.environ, self.special)
            self._master = MasterClient(self.caller_id, uri, timeout=MASTER_TIMEOUT)
        return self._master

    def close(self) -> None:
        """Close the connection to the master, if there is one."""
        if self._master is not None:
            self._master.close()
            self._master = None

    @property
    def graph(self) -> Graph:
        """Questions about this system."""
        from pyros1.graph import Graph  # noqa: PLC0415

        return Graph(self.master)

    def parser(self, usage: str) -> OptionParser:
        """An option parser.

        Args:
            usage: for example ``topic list [/namespace]`` without the program's name.
        """
        from optparse import OptionParser  # noqa: PLC0415 - the quickest commands have no options

        from pyros1.cli.usage import HidingFormatter  # noqa: PLC0415

        parser = OptionParser(usage=f"usage: %prog {usage}", prog=self.program, formatter=HidingFormatter())
        if self.program != self.stock:  # under the stock tool's name help is as that tool's
            parser.format_epilog = self._examples  # type: ignore[method-assign]
        if self.stock == "rosbag" and self.verb != "record":
            self.add_chunk_limit(parser)
        return parser

    def add_chunk_limit(self, parser: OptionParser) -> None:
        """Add the option ``--chunk-limit``, for what reads bags: the environment variable, for this command."""
        from pyros1.bag.limits import CHUNK_LIMIT, LIMIT_VARIABLE, parse_limit  # noqa: PLC0415

        def take(option: object, name: str, value: str, parser: OptionParser) -> None:
            try:
                parse_limit(value, name)
            except Error as error:
                parser.error(str(error))
            os.environ[LIMIT_VARIABLE] = value

        text = f"read chunks of bags up to MB mebibytes (default {CHUNK_LIMIT >> 20}, or ${LIMIT_VARIABLE})"
        text = text if self.program != self.stock else "SUPPRESSHELP"
        parser.add_option("--chunk-limit", type="str", metavar="MB", action="callback", callback=take, help=text)

    def add_json(self, parser: OptionParser, what: str = "print JSON") -> None:
        """Add the option ``--json``; under the stock tool's name help does not mention it."""
        text = what if self.program != self.stock else "SUPPRESSHELP"
        parser.add_option("--json", action="store_true", default=False, help=text)

    def _examples(self, formatter: HelpFormatter) -> str:
        from pyros1.cli.examples import EXAMPLES  # noqa: PLC0415
        from pyros1.cli.usage import examples_text  # noqa: PLC0415

        examples = EXAMPLES.get(f"{self.program.removeprefix('pyros1 ')} {self.verb}")
        return examples_text(f"{self.program} {self.verb}", examples) if examples else ""

    def open_node(self) -> Node:
        """A node for this command, with an anonymous name as the stock tool's (L05).

        Raises:
            MasterUnreachableError: the master is not there; tools do not wait for it.
        """
        self.master.ping()  # says at once, before anything heavy is imported, if there is no master
        from threading import Event  # noqa: PLC0415

        from pyros1.node import Node  # noqa: PLC0415

        node = Node(
            self.stock,
            anonymous=True,
            argv=self.remapping_args,
            environ=self.environ,
            rosout=False,
            wait_for_master=0.0,
            log_level="warn",
        )
        ended = Event()
        node.on_shutdown(ended.set)
        self._wait = ended.wait
        return node

    def pause(self, seconds: float) -> bool:
        """Wait in wall time; returns False, at once, when the command's node ends."""
        return not self._wait(seconds)


def run(
    stock: str,
    argv: list[str],
    verbs: Mapping[str, Callable[[Invocation], int | None]],
    usage: Callable[[str], str],
    *,
    usage_code: int = EX_USAGE,
    error_code: int = 1,
) -> int:
    """Run a command's verb and turn errors into texts and exit codes (L02-L04).

    Args:
        verbs: verb -> function.
        usage: makes the command list, given the program's name.
        usage_code: exit code without a known verb.
        error_code: exit code after an error.
    """
    invocation = Invocation(stock, argv)
    verb = verbs.get(invocation.verb)
    if verb is None:
        print(usage(invocation.program))
        return 0 if _asks_for_help(invocation) else _no_such_verb(invocation, verbs, usage_code)
    try:
        return _run_verb(verb, invocation)
    except BrokenPipeError:
        return quiet_pipe()
    except MasterUnreachableError as error:
        return no_master(error, error_code)
    except CommandError as error:
        flush()
        print(str(error) if error.plain else f"ERROR: {error}", file=sys.stderr)
        return error.code
    except Error as error:
        return report(str(error), error_code)


def _no_such_verb(invocation: Invocation, verbs: Iterable[str], usage_code: int) -> int:
    """Say that there is no such verb, where the list of commands does not suffice; return the exit code."""
    called_otherwise = invocation.program != invocation.stock
    hint = (called_otherwise and elsewhere(invocation.verb)) or did_you_mean(invocation.verb, verbs)
    if not hint and not (invocation.verb and (called_otherwise or invocation.stock == "rosbag")):
        return usage_code
    flush()
    print(f"{invocation.program}: there is no {invocation.verb!r}{hint}", file=sys.stderr)
    return usage_code or EX_USAGE if called_otherwise else usage_code


def elsewhere(verb: str) -> str:
    """A hint at the tool of topic_tools that was looked for among the verbs of topics, and the like."""
    from pyros1.cli.complete_words import VERBS  # noqa: PLC0415 - only what fails needs it
    from pyros1.suggest import SYNONYMS  # noqa: PLC0415

    homes = [f"'pyros1 {command} {verb}'" for command, verbs in VERBS.items() if verb in verbs]
    return f" (did you mean {' or '.join(homes)}?)" if 1 <= len(homes) <= _MOST_HOMES and verb not in SYNONYMS else ""


def _asks_for_help(invocation: Invocation) -> bool:
    """Whether the command list is what was wanted; under their own names only some of stock's tools see it so."""
    if invocation.program != invocation.stock:
        return invocation.verb in ("-h", "--help")
    return invocation.verb == "--help" and invocation.stock in ("rosnode", "rosmsg", "rossrv")


def _run_verb(verb: Callable[[Invocation], int | None], invocation: Invocation) -> int:
    try:
        code = verb(invocation)
        sys.stdout.flush()
        return code or 0
    finally:
        invocation.close()


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """A hint at what a misspelt word may mean, to be put behind a message; empty if nothing is near."""
    from pyros1.suggest import did_you_mean as hint  # noqa: PLC0415 - only what fails needs it

    return hint(word, known)


def use_colour(stream: TextIO) -> bool:
    """Whether to write colours: to a terminal that has them, unless NO_COLOR is set (https://no-color.org)."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def print_json(value: Any) -> None:
    """Print a value as one line of JSON."""
    import json  # noqa: PLC0415

    print(shown.json_text(json.dumps(value, ensure_ascii=False)))


def report(text: str, code: int) -> int:
    """Print an error and return the exit code."""
    flush()
    print(f"ERROR: {text}", file=sys.stderr)
    return code


def no_master(error: MasterUnreachableError, code: int) -> int:
    """Print that the master does not answer, in stock's words, and where, why and what to do; return the exit code."""
    return report(f"Unable to communicate with master!\n{error}", code)


def flush() -> None:
    """Write out what was printed, so that it stands before an error's text; a closed pipe does not matter any more."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        quiet_pipe()


def quiet_pipe() -> int:
    """After the reader of our output went away: let the interpreter end without complaint."""
    output.abandon()
    return 0


def fail(text: str, code: int = 1) -> NoReturn:
    """End the command with a text that is printed as it is."""
    raise CommandError(text, code, plain=True)


_MOST_HOMES = 3
_GUARD = "\0"


def guard_negatives(arguments: list[str]) -> list[str]:
    """Mark negative numbers, so that they are not taken for options; `unguard` the arguments after parsing."""
    return [_GUARD + arg if _is_negative_number(arg) else arg for arg in arguments]


def unguard(argument: str) -> str:
    """Remove the mark of `guard_negatives`."""
    return argument.removeprefix(_GUARD)


def _is_negative_number(text: str) -> bool:
    if not text.startswith("-"):
        return False
    try:
        float(text)
    except ValueError:
        return False
    return True
