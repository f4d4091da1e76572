"""What ``tests/mutants`` runs: choose mutants, run the tests that reach them, report those that survive."""

from __future__ import annotations

import argparse
import contextlib
import difflib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import coverage
from equivalent import name_of, names_in
from mutate import Mutant, choose, mutants

ROOT = Path(__file__).resolve().parents[2]
SOURCES = Path("src/pyros1")
EQUIVALENT = Path(__file__).with_name("equivalent.txt")
HANGS = 30  # seconds that one test of a mutant may take; longer than any takes unchanged
LEFT_OUT = shutil.ignore_patterns(".git", ".venv*", "build", "dist", "__pycache__", ".*_cache", ".hypothesis")


@dataclass(frozen=True)
class Case:
    """A mutant of a file, with the tests that reach its line, and the other tests of its room.

    What a function returns is often kept for all later calls: then only the first of them reaches its lines, and a
    mistake there shows in the others, too.
    """

    path: Path
    mutant: Mutant
    tests: tuple[str, ...]
    others: tuple[str, ...]

    @property
    def name(self) -> str:
        """As ``equivalent.txt`` names it."""
        return name_of(self.path, (ROOT / self.path).read_text(), self.mutant)


@dataclass
class Result:
    """What became of the mutants."""

    killed: list[Case] = field(default_factory=list)
    hung: list[Case] = field(default_factory=list)
    survived: list[Case] = field(default_factory=list)
    unreached: list[Case] = field(default_factory=list)
    equivalent: list[Case] = field(default_factory=list)


def main() -> int:
    """Return 0 if every mutant was noticed, 1 if not."""
    parser = argparse.ArgumentParser(prog="tests/mutants", description="Make mistakes; see whether a test notices.")
    parser.add_argument("rooms", nargs="*", help="rooms of src/pyros1 (wire, node, bag/format), or files")
    parser.add_argument("--without", nargs="*", default=[], help="rooms or files to leave out of them")
    parser.add_argument("--sample", type=positive, help="how many mutants, chosen at random (default: all)")
    parser.add_argument(
        "--seed", type=int, default=1, help="chooses them; the same seed, the same mutants (default: 1)"
    )
    parser.add_argument("--jobs", type=positive, default=os.cpu_count() or 1, help="mutants at a time")
    parser.add_argument("--tests", nargs="*", help="files or folders of tests (default: those of the rooms)")
    parser.add_argument("--at", type=place, metavar="FILE:LINE", help="the mutants of one line, with their diffs")
    options = parser.parse_args()
    line = None
    if options.at:
        file, line = options.at
        options.rooms = [file]
    if not options.rooms:
        parser.error("which rooms? for example: wire")
    files = sorted(
        {file for room in options.rooms for file in modules(room)}
        - {file for room in options.without for file in modules(room)}
    )
    if not files:
        parser.error(f"no modules in {' '.join(options.rooms)}")
    tests = options.tests or sorted({tests_of(room) for room in options.rooms})
    print(f"running {' '.join(tests)} to see which test reaches which line", flush=True)
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        reached, seconds = reach(Path(folder) / "reach", tests)
        found = [
            (file, mutant)
            for file in files
            for mutant in mutants((ROOT / file).read_bytes())
            if line in (None, mutant.line)
        ]
        if options.sample is not None and options.sample < len(found):
            texts = {file: (ROOT / file).read_text() for file in files}
            names = [name_of(file, texts[file], mutant) for file, mutant in found]
            found = [found[index] for index in choose(names, options.sample, options.seed)]
        cases = [make_case(reached, file, mutant) for file, mutant in found]
        print(f"{len(cases)} mutants; the unchanged tests took {seconds:.0f} s", flush=True)
        result = run(cases, options.jobs, Path(folder), diffs=line is not None)
    return report(result, len(cases), options.seed)


def positive(text: str) -> int:
    """Return a number above 0 of the command line."""
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"not a number above 0: {text!r}")
    return int(text)


def place(text: str) -> tuple[str, int]:
    """Return a file and a line of it from the command line."""
    file, _, number = text.rpartition(":")
    if not file or not number.isdecimal():
        raise argparse.ArgumentTypeError(f"not a file and a line, such as src/pyros1/node/clock.py:120: {text!r}")
    return file, int(number)


def modules(room: str) -> list[Path]:
    """Return the modules of a room, as paths from the checkout's root; none for a file outside the sources."""
    path = Path(room) if room.endswith(".py") else SOURCES / room
    if not path.is_relative_to(SOURCES):
        return []
    whole = ROOT / path
    files = [whole] if whole.is_file() else whole.rglob("*.py")
    return [file.relative_to(ROOT) for file in files]


def tests_of(room: str) -> str:
    """Return the folder of tests of a room, or of the room of a file: those of ``bag`` for ``bag/format``, too."""
    path = Path(room).relative_to(SOURCES) if room.endswith(".py") else Path(room)
    return str(Path("tests") / path.parts[0])


def copy_checkout(target: Path) -> None:
    """Copy what tests need. Compiled files are checked by their source's hash: a mutant may be as old and as long."""
    shutil.copytree(ROOT, target, ignore=LEFT_OUT, symlinks=True)
    subprocess.run(
        [sys.executable, "-m", "compileall", "-q", "--invalidation-mode", "checked-hash", "src"],
        cwd=target,
        check=False,
    )


def environment(copied: Path) -> dict[str, str]:
    """Return environment variables with which the tests of a copy import that copy."""
    return os.environ | {"PYTHONPATH": f"{copied / 'src'}:{copied / 'tests' / 'mutation'}"}


def reach(copied: Path, tests: list[str]) -> tuple[coverage.CoverageData, float]:
    """Run the tests once, unchanged; return what they reached, and how many seconds they took."""
    copy_checkout(copied)
    began = time.monotonic()
    pytest = [sys.executable, "-m", "coverage", "run", "--rcfile=/dev/null"]
    pytest += [f"--source={copied / SOURCES}", "--data-file=reached"]
    done = subprocess.run(
        [*pytest, "-m", "pytest", "-p", "reach", "-p", "no:cacheprovider", *tests],
        cwd=copied,
        env=environment(copied),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        sys.exit(f"{done.stdout[-4000:]}{done.stderr[-2000:]}tests/mutants: the tests fail without any mutant")
    data = coverage.CoverageData(str(copied / "reached"))
    data.read()
    return data, time.monotonic() - began


def make_case(reached: coverage.CoverageData, file: Path, mutant: Mutant) -> Case:
    """Return a mutant with its tests."""
    tests = tests_at(reached, file, mutant)
    room = f"{tests_of(str(file))}/"
    others = sorted({test for test in reached.measured_contexts() if test.startswith(room)}.difference(tests))
    return Case(file, mutant, tests, tuple(others))


def tests_at(reached: coverage.CoverageData, file: Path, mutant: Mutant) -> tuple[str, ...]:
    """
    Return the tests that reach a mutant: all of them for a line that runs when its module is imported.

    If none does in its own process, a child may do it: then those of the module are returned, or those of its folder.
    Those that most likely notice it come first: of the file of tests with the module's name, then of its folder.
    """
    name = next((name for name in reached.measured_files() if name.endswith(f"/{file}")), "")
    contexts = reached.contexts_by_lineno(name).get(mutant.line, [])
    if contexts and not any(contexts):
        contexts = list(reached.measured_contexts())
    mirrored = Path("tests") / file.relative_to(SOURCES)

    def order(test: str) -> tuple[bool, bool, str]:
        path = Path(test.partition("::")[0])
        return path.parent != mirrored.parent, path.name != f"test_{mirrored.name}", test

    if not contexts:
        near = [test for test in reached.measured_contexts() if test and not order(test)[0]]
        contexts = [test for test in near if not order(test)[1]] or near
    return tuple(sorted((test for test in contexts if test), key=order))


def run(cases: list[Case], jobs: int, folder: Path, diffs: bool) -> Result:
    """Run the tests of each mutant, several mutants at a time, each worker in a copy of its own."""
    result = Result()
    known = names_in(EQUIVALENT.read_text())
    local = threading.local()
    printing = threading.Lock()

    def one(case: Case) -> None:
        if not hasattr(local, "copy"):
            local.copy = Path(tempfile.mkdtemp(dir=folder)) / "checkout"
            copy_checkout(local.copy)
        if case.name in known:
            word, kind = "equivalent", result.equivalent
        elif not case.tests:
            word, kind = "unreached", result.unreached
        else:
            word = outcome(case, case.tests, local.copy)
            if word == "survived" and case.others:
                word = outcome(case, case.others, local.copy)
            kind = {"killed": result.killed, "hung": result.hung, "survived": result.survived}[word]
        with printing:
            kind.append(case)
            if word in ("survived", "unreached") or diffs:
                print(f"{word} at line {case.mutant.line}: {case.name}", flush=True)
            if diffs:
                print(difference(case), flush=True)

    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(one, cases))
    return result


def outcome(case: Case, tests: tuple[str, ...], copied: Path) -> str:
    """Return ``killed``, ``hung`` or ``survived``: what some tests say of a mutant."""
    file = copied / case.path
    unchanged = file.read_bytes()
    names = copied / "names"
    names.write_text("\n".join(tests))
    file.write_bytes(case.mutant.apply(unchanged))
    command = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", f"--timeout={HANGS}", "@names"]
    process = subprocess.Popen(
        command,
        cwd=copied,
        env=environment(copied),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return "killed" if process.wait(30 + 2 * len(tests)) else "survived"
    except subprocess.TimeoutExpired:
        return "hung"
    finally:
        file.write_bytes(unchanged)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def difference(case: Case) -> str:
    """Return a mutant as a diff."""
    before = (ROOT / case.path).read_bytes()
    texts = (before.decode().splitlines(), case.mutant.apply(before).decode().splitlines())
    return "\n".join(difflib.unified_diff(*texts, n=1, lineterm=""))


def report(result: Result, count: int, seed: int) -> int:
    """Print the figures; return the exit code."""
    noticed = len(result.killed) + len(result.hung)
    alive = len(result.survived) + len(result.unreached)
    print(
        f"{count} mutants (seed {seed}): {noticed} killed ({len(result.hung)} of them by a time limit), "
        f"{len(result.survived)} survived, {len(result.unreached)} in lines that no test reaches, "
        f"{len(result.equivalent)} explained: {100 * alive / max(count, 1):.1f} % survive"
    )
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
