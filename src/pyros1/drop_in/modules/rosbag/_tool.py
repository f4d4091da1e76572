"""What the tool rosbag has inside: its verbs, its options, its progress, and its work on many bags."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections import UserDict
from collections.abc import Callable, Sequence
from typing import Any

import rosbag
from rosbag.bag import Bag

_HEAD = (
    "Usage: rosbag <subcommand> [options] [args]\n\n"
    "A bag is a file format in ROS for storing ROS message data. "
    "The rosbag command can record, replay and manipulate bags.\n"
)
_TAIL = "For additional information, see http://wiki.ros.org/rosbag\n"


class RosbagCmds(UserDict[str, Callable[[list[str]], object]]):
    """Verb -> function, called with the words after the verb; ``help`` is there from the beginning."""

    def __init__(self) -> None:
        super().__init__()
        self._texts: dict[str, str] = {}
        self["help"] = self.help_cmd

    def add_cmd(self, name: str, function: Callable[[list[str]], object], description: str) -> None:
        """Add a verb."""
        self[name] = function
        self._texts[name] = description

    def get_valid_cmds(self) -> str:
        """Return the list of verbs, as text."""
        lines = "".join(f"   {name}  \t{self._texts.get(name, '')}".rstrip("\t") + "\n" for name in sorted(self))
        return f"Available subcommands:\n{lines}"

    def help_cmd(self, argv: list[str]) -> None:
        """Print the help."""
        print(f"{_HEAD}\n{self.get_valid_cmds()}\n{_TAIL}")


# Options: called by optparse ----------------------------------------------------------------------------------------


def handle_split(option: Any, opt_str: str, value: Any, parser: Any) -> None:
    """Take the option ``--split``, and the size in MB that may follow it."""
    parser.values.split = True
    if parser.rargs and parser.rargs[0].isdigit():
        sys.stderr.write(
            'Use of "--split <MAX_SIZE>" has been deprecated.  '
            "Please use --split --size <MAX_SIZE> or --split --duration <MAX_DURATION>\n"
        )
        parser.values.size = int(parser.rargs.pop(0))


def _take_words(words: list[str], taken: list[str]) -> None:
    """Move the words up to the next option."""
    count = next((i for i, word in enumerate(words) if word[:1] == "-" and word != "-"), len(words))
    taken.extend(words[:count])
    del words[:count]


def handle_topics(option: Any, opt_str: str, value: Any, parser: Any) -> None:
    """Take the topics behind the option ``--topics``."""
    _take_words(parser.rargs, parser.values.topics)


def handle_pause_topics(option: Any, opt_str: str, value: Any, parser: Any) -> None:
    """Take the topics behind the option ``--pause-topics``."""
    _take_words(parser.rargs, parser.values.pause_topics)


# Output -------------------------------------------------------------------------------------------------------------


def print_trans(old: Any, new: Any, indent: int) -> None:
    """Print a step of a migration: a message's class, and the class that it becomes; None if that is not known."""

    def named(cls: Any) -> str:
        return f"{cls._type} [{cls._md5sum}]"

    space = "    " * indent
    print(f"{space} * From: {named(old)}")
    print(f"{space}   To:   {'Unknown' if new is None else named(new)}")


class ProgressMeter:
    """Shows on one line of the terminal how much of a file is done.

    Args:
        path: of the file.
        bytes_total: its size.
        refresh_rate: seconds between two changes of the line.

    Attributes:
        bytes_read: what is done. elapsed: seconds since the beginning.
    """

    def __init__(self, path: str, bytes_total: int, refresh_rate: float = 1.0) -> None:
        self.path = path
        self.bytes_total = bytes_total
        self.refresh_rate = refresh_rate
        self.bytes_read = 0
        self.elapsed = 0.0
        self.update_elapsed = 0.0
        self.start_time = time.time()
        self._show()

    def step(self, bytes_read: int, force_update: bool = False) -> None:
        """Tell how much is done, in bytes; ``force_update``: show it at once."""
        self.bytes_read = bytes_read
        self.elapsed = time.time() - self.start_time
        if force_update or self.elapsed - self.update_elapsed > self.refresh_rate:
            self._show()
            self.update_elapsed = self.elapsed

    def finish(self) -> None:
        """All is done: show it, and end the line."""
        self.step(self.bytes_total, force_update=True)
        print()

    def _show(self) -> None:
        done = self.bytes_read / self.bytes_total if self.bytes_total else 1.0
        if self.bytes_read >= self.bytes_total:
            facts = f"100%{_size(self.bytes_total):>20} {_clock(self.elapsed)}    "
        else:
            left = _clock(self.elapsed * (1 / done - 1)) if done else "--:--"
            facts = f"{int(100 * done):3d}% {_size(self.bytes_read)} / {_size(self.bytes_total)} {left} ETA"
        width = max(self.terminal_width() - 37, 3)  # beside the facts
        name = self.path if len(self.path) <= width else "..." + (self.path[3 - width :] if width > 3 else "")
        sys.stdout.write(f"\r {name:<{max(width, 7)}} {facts}")
        sys.stdout.flush()

    @staticmethod
    def terminal_width() -> int:
        """Return the columns of the terminal; 80 without one."""
        return shutil.get_terminal_size((80, 24)).columns


def _size(count: float) -> str:
    for unit in ("KB", "MB", "GB"):
        count /= 1024
        if count < 1024:
            return f"{count:5.1f} {unit}"
    return f"{count / 1024:5.1f} TB"


def _clock(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes:02d}:{rest:02d}"


# Work on many bags --------------------------------------------------------------------------------------------------


def bag_op(
    inbag_filenames: Sequence[str],
    allow_unindexed: bool,
    open_inbag: Any,
    copy_fn: Callable[[Bag], bool],
    op: Callable[..., object],
    output_dir: str | None = None,
    force: bool = False,
    quiet: bool = False,
) -> None:
    """Do something with each of some bags. The old file stays as ``NAME.orig.bag``, unless there is a folder.

    Args:
        inbag_filenames: paths of the bags.
        allow_unindexed: take also bags that were not closed.
        open_inbag: whether ``op`` gets the old bag open, else its path.
        copy_fn: called with the old bag; tells whether the new one is a copy to change, else it is empty.
        op: called with the old bag, the new bag, and ``quiet=``.
        output_dir: folder of the new bags; None: they take the place of the old ones.
        force: write over what is there.
        quiet: print nothing.
    """
    for path in inbag_filenames:
        try:
            with Bag(path, allow_unindexed=allow_unindexed) as bag:
                copied = copy_fn(bag)
        except (OSError, rosbag.ROSBagException) as error:
            _complain(f"ERROR reading {path}: {error}")
            continue
        if output_dir is None:
            old, new = "{}.orig{}".format(*os.path.splitext(path)), path
            if os.path.exists(old) and not force:
                if not quiet:
                    _complain(f"Skipping {path}. Backup path {old} already exists.")
                continue
            os.replace(path, old)
        else:
            old, new = path, os.path.join(output_dir, os.path.basename(path))
        if not _one(old, new, copied, allow_unindexed, open_inbag, op, quiet):
            if output_dir is None:
                os.replace(old, new)
            return


def _one(old: str, new: str, copied: bool, unindexed: bool, opened: Any, op: Any, quiet: bool) -> bool:
    """Process one bag. If interrupted, remove the new bag and return False."""
    if copied:
        shutil.copy(old, new)
    try:
        outbag = Bag(new, "a" if copied else "w", allow_unindexed=unindexed)
    except (OSError, rosbag.ROSBagException) as error:
        _complain(f"ERROR writing to {new}: {error}")
        return True
    inbag: Any = old
    try:
        inbag = Bag(old, allow_unindexed=unindexed) if opened else old
        op(inbag, outbag, quiet=quiet)
    except rosbag.ROSBagException as error:
        _complain(f"ERROR operating on {old}: {error}")
    except KeyboardInterrupt:
        outbag.close()
        os.remove(new)
        return False
    finally:
        outbag.close()
        if inbag is not old:
            inbag.close()
    return True


def _complain(text: str) -> None:
    print(text, file=sys.stderr)
