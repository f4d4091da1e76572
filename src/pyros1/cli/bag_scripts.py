"""The scripts of the package rosbag, under their own names: what they do, the commands of ``bag`` do too (L146)."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Callable
from optparse import OptionParser

from pyros1.bag import edit
from pyros1.bag.api import Bag
from pyros1.bag.errors import BagError
from pyros1.bag.reader import BagReader, RawMessage
from pyros1.bag.records import Connection
from pyros1.cli.bag_edit import content_size, rename_topic
from pyros1.cli.bag_files import different, keep, new_file
from pyros1.cli.bag_fix import make_migrator, migrate, migration_of, write_rules
from pyros1.cli.bag_info import report_bag_error
from pyros1.cli.common import CommandError, Invocation
from pyros1.cli.shared.progress import Progress
from pyros1.errors import MessageError
from pyros1.msgs import from_definition, load_message

_SAVED = re.compile(r"\[(.+)\]:\s*\n")


def bagsort(invocation: Invocation) -> None:
    """``bagsort.py IN OUT``, and ``fastrebag.py``: the same messages, by time."""
    source, target = _arguments(invocation, "INBAG OUTBAG", 2)
    _rewrite(source, target, lambda connection: connection)


def topic_renamer(invocation: Invocation) -> None:
    """``topic_renamer.py TOPIC IN NEW OUT``."""
    topic, source, new, target = _arguments(invocation, "INTOPIC INBAG OUTTOPIC OUTBAG", 4)
    rename_topic(Invocation(invocation.stock, ["rename-topic", source, target, topic, new], invocation.environ))


def fixbag(invocation: Invocation) -> int:
    """``fixbag.py IN OUT [RULES...]``."""
    source, target, *rules = _arguments(invocation, "INBAG OUTBAG [RULEFILE1 RULEFILE2 ...]", 2, more=True)
    if target.endswith(".bmr"):
        raise CommandError("Second argument should be a bag, not a rule file.", 2, plain=True)
    different(source, target)
    with Bag(source, unindexed=False) as bag:
        failing = migrate(bag, target, make_migrator(rules))
    print("Bag could not be migrated." if failing else "Bag migrated successfully.")
    return int(bool(failing))


def fixbag_batch(invocation: Invocation) -> int:
    """``fixbag_batch.py BAG...``: each is replaced, the old one kept as ``NAME.bag.old``."""

    def operation(source: str, target: str) -> bool:
        with Bag(source, unindexed=False) as bag:
            return not migrate(bag, target, make_migrator([]))

    return _replace_each(_arguments(invocation, "BAG1 [BAG2 ...]", 1, more=True), operation)


def fix_md5sums(invocation: Invocation) -> int:
    """``fix_md5sums.py BAG...``: each is written anew; the old one kept as ``NAME.bag.old``."""

    def operation(source: str, target: str) -> bool:
        _rewrite(source, target, lambda connection: connection, quiet=True)
        return True

    return _replace_each(_arguments(invocation, "BAG1 [BAG2 ...]", 1, more=True), operation)


def fix_msg_defs(invocation: Invocation) -> None:
    """``fix_msg_defs.py IN OUT``: wrong definitions become this system's, if those have the right md5 sum."""
    source, target = _arguments(invocation, "INBAG OUTBAG", 2)
    _rewrite(source, target, _with_definition)


def fix_moved_messages(invocation: Invocation) -> None:
    """``fix_moved_messages.py FILE IN OUT``: FILE has lines ``TYPE MD5SUM NEW_TYPE NEW_MD5SUM``."""
    file, source, target = _arguments(invocation, "NAME_MD5_FILE INBAG OUTBAG", 3)
    moves: dict[tuple[str, str], tuple[str, str]] = {}
    with open(file, encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            words = line.split()
            if words and len(words) != 4:
                raise CommandError(f"{file}:{number}: four words are needed: TYPE MD5SUM NEW_TYPE NEW_MD5SUM")
            if words:
                moves[words[0], words[1]] = (words[2], words[3])

    def moved(connection: Connection) -> Connection:
        to = moves.get((connection.type, connection.md5sum))
        return connection if to is None else _with_definition(_changed(connection, type=to[0], md5sum=to[1]))

    _rewrite(source, target, moved)


def savemsg(invocation: Invocation) -> None:
    """``savemsg.py [-b BAG] TYPE``: print a definition in full, for ``makerule.py``."""
    parser = _parser(invocation, "[-b BAGFILE] TYPE")
    parser.add_option("-b", "--bagfiles", dest="bagfile", help="as it is in a bag, not in this system")
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("Message type not specified.")
    name = args[0]
    if options.bagfile is None:
        text = load_message(name)._full_text
    else:
        with BagReader(options.bagfile) as bag:
            texts = [connection.definition for connection in bag.connections.values() if connection.type == name]
        if not texts:
            raise CommandError(f"Could not find message {name} in bag {options.bagfile}.", plain=True)
        text = texts[0]
    print(f"[{name}]:\n{text}")


def makerule(invocation: Invocation) -> int:
    """``makerule.py SAVED RULES [MORE_RULES...]``: rules that bring a definition of ``savemsg.py`` to this system's."""
    parser = _parser(invocation, "MSG.SAVED [-a] OUTPUT_RULEFILE [RULEFILE1 RULEFILE2 ...] [-n]")
    parser.add_option("-a", "--append", action="store_true", help="append to the rule file, after loading it")
    parser.add_option("-n", "--noplugins", action="store_true", help="do not load rulefiles via plugins")
    options, args = parser.parse_args(invocation.args)
    if len(args) < 2:
        parser.error("Incorrect number of arguments")
    saved, target, *rules = args
    if os.path.isfile(target) != bool(options.append):
        reason = "does not exist, and so -a is invalid" if options.append else "already exists. Include -a to append"
        raise CommandError(f"The file {target} {reason}.", plain=True)
    with open(saved, encoding="utf-8") as file:
        text = file.read()
    first = _SAVED.match(text)
    if first is None:
        raise CommandError(f"{saved}: the first line must be the type as savemsg.py prints it: [package/Type]:")
    migrator = make_migrator([*rules, *([target] if options.append else [])])
    migration = migration_of(from_definition(first[1], text[first.end() :]), migrator)
    if migration is None:
        print("Saved definition is up to date.")
        return 0
    write_rules([migration], target)
    return 0


def _parser(invocation: Invocation, usage: str) -> OptionParser:
    return OptionParser(f"usage: %prog {usage}", prog=invocation.verb)


def _arguments(invocation: Invocation, usage: str, count: int, *, more: bool = False) -> list[str]:
    parser = _parser(invocation, usage)
    _, args = parser.parse_args(invocation.args)
    if len(args) < count or (len(args) > count and not more):
        parser.error("Incorrect number of arguments")
    return args


def _rewrite(source: str, target: str, change: Callable[[Connection], Connection], *, quiet: bool = False) -> None:
    """Write the messages of a bag into another one, with connections that a function makes of the old ones."""
    different(source, target)
    with BagReader(source) as bag, new_file(target) as part:
        new = {number: change(connection) for number, connection in bag.connections.items()}
        messages = (RawMessage(new[stored.connection.id], stored.time, stored.data) for stored in bag.messages())
        with Progress(target, content_size(bag), quiet=quiet) as progress:
            edit.copy(messages, part, cipher=bag.file.cipher, progress=progress)


def _with_definition(connection: Connection) -> Connection:
    """Return a connection with the definition that its md5 sum is of, if this system has it."""
    try:
        if from_definition(connection.type, connection.definition)._md5sum == connection.md5sum:
            return connection
    except MessageError:
        pass  # no definition at all is a wrong one, too
    try:
        cls = load_message(connection.type)
    except MessageError:
        cls = None
    if cls is None or cls._md5sum != connection.md5sum:
        print(f"{connection.topic}: {connection.type} [{connection.md5sum}] is not known here", file=sys.stderr)
        return connection
    return _changed(connection, message_definition=cls._full_text)


def _changed(connection: Connection, **fields: str) -> Connection:
    header = dict(connection.header) | {name: value.encode() for name, value in fields.items()}
    return Connection(connection.id, connection.topic, header)


def _replace_each(paths: list[str], operation: Callable[[str, str], bool]) -> int:
    """Replace bags; the old ones are kept as ``NAME.old``, ``NAME.old2``, ...

    Args:
        operation: given the old file and the new one, writes that; returns whether it could.

    Returns:
        The exit code: 1 if one could not be replaced.
    """
    failed = False
    for path in paths:
        print(f"Trying to migrate: {path}", flush=True)
        part = f"{path}.tmp"
        try:
            if not operation(path, part):
                print(" Migration failed.")
                failed = True
                continue
            backup, number = f"{path}.old", 1
            while os.path.exists(backup):
                number += 1
                backup = f"{path}.old{number}"
            shutil.copymode(path, part)
            keep(path, backup)
            os.replace(part, path)
            print(f" Migration successful.  Original stored as: {backup}")
        except (BagError, OSError) as error:
            report_bag_error(error, path)
            failed = True
    return int(failed)
