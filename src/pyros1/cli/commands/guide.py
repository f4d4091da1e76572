"""``pyros1 guide``: prints the steps of an introduction to ROS 1, and how-to pages."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Command, Flag, Verb
from pyros1.cli.shared.printing import should_use_colour
from pyros1.ground.suggest import did_you_mean

if TYPE_CHECKING:
    from pyros1.guide.documents import GuidePage, GuideStep

_MAX_WIDTH = 100


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """List the steps or pages, print one, write a step's files, or check its exercise. Return 1 after a failure."""
    from pyros1.guide.documents import steps  # noqa: PLC0415 - not needed for help

    if args[:1] == ["howto"]:
        return _run_howto(args[1:])
    all_steps = steps()
    if not args and not options.write:
        print("The guide: ROS 1 in hands-on steps. pyros1 guide 1 shows the first.\n")
        print("\n".join(f"{step.number:3}. {step.title}" for step in all_steps))
        print("\nEach step ends with an exercise; pyros1 guide check 1 checks the first.")
        print("How-to pages for particular tasks: pyros1 guide howto")
        return 0
    is_check = args[:1] == ["check"]
    step_numbers = args[1:] if is_check else args
    if len(step_numbers) != 1 or not step_numbers[0].isdigit() or not 1 <= int(step_numbers[0]) <= len(all_steps):
        raise UsageError(
            f"say which step: pyros1 guide {'check ' * is_check or '-w ' * options.write}1 ... {len(all_steps)}"
        )
    step = all_steps[int(step_numbers[0]) - 1]
    if options.write:
        return _write_files(step)
    if not is_check:
        _print_page(step)
        if step.files:
            print(f"\npyros1 guide -w {step.number} writes the files of this step to the current folder.")
        return 0
    from pyros1.guide.checks import check  # noqa: PLC0415 - only checks need nodes

    missing_text = check(step.number)
    if missing_text:
        print(f"{step.number}. {step.title} is not done yet: {missing_text}")
        return 1
    next_hint = f" Next: pyros1 guide {step.number + 1}" if step.number < len(all_steps) else " That was the last step."
    print(f"{step.number}. {step.title}: done.{next_hint}")
    return 0


def _run_howto(names: list[str]) -> int:
    """List the how-to pages, or print one of them."""
    from pyros1.guide.documents import pages  # noqa: PLC0415

    all_pages = pages()
    if not names:
        print("How-to pages: pyros1 guide howto NAME shows one.\n")
        name_width = max(map(len, all_pages))
        print("\n".join(f"  {page.name:{name_width}}  {page.heading}" for page in all_pages.values()))
        return 0
    if len(names) > 1 or names[0] not in all_pages:
        hint = did_you_mean(names[0], all_pages) if len(names) == 1 else ""
        raise UsageError(f"there is no page {' '.join(names)}{hint}; the pages are {', '.join(all_pages)}")
    _print_page(all_pages[names[0]])
    return 0


def _print_page(page: GuideStep | GuidePage) -> None:
    """Print a step or page."""
    from pyros1.guide.documents import format_for_terminal  # noqa: PLC0415

    width = min(shutil.get_terminal_size().columns, _MAX_WIDTH)
    print(format_for_terminal(page, width, should_use_colour(sys.stdout)), end="")


def _write_files(step: GuideStep) -> int:
    """Write the step's files to the current folder. Return 1 if one of them exists with different contents."""
    for name, content in step.files.items():
        path = Path(name)
        if path.exists() and path.read_text(encoding="utf-8") != content:
            print(f"{name} already exists with different contents: rename it and try again", file=sys.stderr)
            return 1
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
        if content.startswith("#!"):
            path.chmod(0o755)
        print(f"wrote {name}")
    if not step.files:
        print("this step has no files")
    return 0


COMMAND = Command(
    "guide",
    "learn ROS 1 step by step: a package, topics, launch files, bags, a simulator ...",
    Verb(
        "",
        "",
        Flag(
            "-w",
            "--write",
            help="write the files of a step to the current folder, to save typing",
        ),
        Argument("step", "guide", repeatable=True, optional=True),
        usage="[STEP | -w STEP | check STEP | howto [NAME]]\n\n"
        "A hands-on introduction to ROS 1, and how-to pages. Without arguments: list the steps.",
        examples=[
            ("", "list the steps"),
            ("3", "show the third step"),
            ("-w 2", "write the files of the second step to this folder"),
            ("check 3", "check the exercise of the third step and print what is missing"),
            ("howto", "list the how-to pages"),
            ("howto actions", "show how to write action servers and clients"),
        ],
        run=run,
    ),
    group="learn",
)
