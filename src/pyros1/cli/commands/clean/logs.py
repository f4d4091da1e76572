"""``clean check`` prints the size of the log files, and ``clean purge`` removes log files (L179).

Files outside the log folders are never removed. Logs that are still being written are removed only with ``--running``.
"""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from pathlib import Path
from typing import Any

from pyros1.cli.commands.clean._folders import existing_log_folders
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_unparsed
from pyros1.cli.records import JSON_FLAG, Flag, Option, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.doctor.disk import files_in_use, folder_size, format_size_like_du

_MEGABYTE = 1024 * 1024


def _print_sizes(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the size of each log folder."""
    rows = [(label, folder, folder_size(folder, on_disk=True)) for folder, label in existing_log_folders()]
    if options.json:
        print_json([{"what": label, "folder": str(folder), "bytes": size} for label, folder, size in rows])
        return
    for label, _, size in rows:
        print(f"{format_size_like_du(size)} {label}")


def _purge(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Remove all logs, or the oldest ones until a size limit is met. Return 1 if something could not be removed."""
    all_succeeded = True
    for folder, label in existing_log_folders():
        if _contains_home(folder):
            print(f"will not remove {folder}: it is or contains your home folder; correct ROS_LOG_DIR", file=sys.stderr)
            return 1
        kept_entries = set() if options.running else _entries_in_use(folder)
        succeeded = (_purge_to_size if options.size else _purge_all)(folder, label, options, kept_entries)
        if succeeded is None:  # the user declined
            if options.size:
                return 0
            continue
        all_succeeded = all_succeeded and succeeded
        if kept_entries:
            kept_names = ", ".join(sorted(kept_entries))
            print(
                f"kept, because running programs write to these logs: {kept_names} (--running removes them as well)",
                file=sys.stderr,
            )
    return 0 if all_succeeded else 1


def _entries_in_use(folder: Path) -> set[str]:
    """Return the entries of a folder that running programs have open, and links to them such as ``latest``."""
    used_entries = {path.relative_to(folder).parts[0] for path in files_in_use(folder)}
    real_folder = folder.resolve()
    links = {path.name for path in folder.iterdir() if path.is_symlink()} if used_entries else set()
    return used_entries | {
        name for name in links if (folder / name).resolve() in {real_folder / entry for entry in used_entries}
    }


def _purge_all(folder: Path, label: str, options: Any, kept_entries: set[str]) -> bool | None:
    """Remove all logs. Return whether all were removed; None if the user declined."""
    print(f"Purging {label}.")
    if not options.yes:
        print("PLEASE BE CAREFUL TO VERIFY THE COMMAND BELOW!")
        quoted_folder = f'"{folder}"' if " " in str(folder) else str(folder)
        exception_note = f" (except {', '.join(map(shlex.quote, sorted(kept_entries)))})" if kept_entries else ""
        if not _confirm(f"rm -rf {quoted_folder}{exception_note}"):
            return None
    if not kept_entries:
        return _remove(folder)
    results = [_remove(folder / name) for name in os.listdir(folder) if name not in kept_entries]
    return all(results)


def _purge_to_size(folder: Path, label: str, options: Any, kept_entries: set[str]) -> bool | None:
    """Remove the oldest logs until the folder is small enough. The return value is as in `_purge_all`."""
    limit, size = options.size * _MEGABYTE, folder_size(folder)
    if size <= limit:
        print(
            f"Directory size of {label} is {size // _MEGABYTE} MB which is already below the requested threshold of "
            f"{options.size} MB."
        )
        return True
    print(
        f"Purging {label} until directory size is at most {options.size} MB (currently {size // _MEGABYTE} MB).",
        flush=True,
    )
    if not options.yes:
        print("PLEASE BE CAREFUL TO VERIFY THE COMMAND BELOW!")
        if not _confirm(f"Purge some of old logs in {folder}"):
            return None
    all_succeeded = True
    for path in sorted(folder.iterdir(), key=lambda path: path.lstat().st_mtime):
        if size <= limit:
            break
        if path.name not in kept_entries:
            size -= folder_size(path)
            all_succeeded = _remove(path) and all_succeeded
    return all_succeeded


def _confirm(question: str) -> bool:
    """Ask until the user answers y or n. Return whether the answer is y; the end of the input means n."""
    print(f"Okay to perform:\n\n{question}\n(y/n)?", flush=True)
    for line in sys.stdin:
        answer = line.strip().lower()
        if answer in ("y", "n"):
            return answer == "y"
    return False


def _remove(path: Path) -> bool:
    """Remove a file, a link, or a folder and its contents. Links are not followed. Return whether it was removed."""
    try:
        if path.is_symlink() or not path.is_dir():
            path.unlink()
        else:
            shutil.rmtree(path)
    except FileNotFoundError:
        pass  # another process has removed the file
    except OSError as error:
        print(f"FAILED to execute command: cannot remove {error.filename}: {error.strerror}", file=sys.stderr)
        return False
    return True


def _contains_home(folder: Path) -> bool:
    """Return whether a folder is the user's home or one of its parents, such as ``/``."""
    home, folder = Path.home().resolve(), folder.resolve()
    return folder == home or folder in home.parents


VERBS = [
    Verb(
        "check",
        "Check usage of log files",
        JSON_FLAG,
        examples=[("", "print how much space the log files use")],
        parse=leave_unparsed,  # the command parses the arguments
        run=_print_sizes,
    ),
    Verb(
        "purge",
        "Remove log files",
        Flag("-y", dest="yes", help="remove without asking"),
        Option("--size", type=int, help="keep the newest logs, up to this many MB in total"),
        Flag("--running", help="also remove logs of running programs", pyros1_only=True),
        examples=[
            ("", "remove all logs after asking, except those of running programs"),
            ("-y --size 500", "remove the oldest logs until at most 500 MB are left, without asking"),
        ],
        parse=leave_unparsed,  # the command parses the arguments
        run=_purge,
    ),
]
