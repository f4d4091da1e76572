"""A report for remote support: the machine, the findings and the running system as Markdown.

It has no secrets: only environment variables that ROS reads, no values of parameters, no messages; passwords and tokens
in addresses are left out, and folders of the user appear without the user's name.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import metadata

from pyros1.doctor.facts import Machine, NodeFacts, System
from pyros1.doctor.finding import Finding
from pyros1.ground.terminal_text import one_line

ROWS = 200
"""Maximum number of rows of a table; the rest is counted."""
_LIBRARIES = (
    "rosbags", "defusedxml", "PyYAML", "lz4", "numpy", "xacro", "websockets", "pillow", "cbor2", "av", "cryptography",
)  # fmt: skip
_LIBRARIES_WITHOUT_ROS = ("rospkg", "catkin-pkg", "setuptools", "pip")
_READ = re.compile(r"ROS_\w+|ROSCONSOLE_\w+|PYROS1_\w+|CMAKE_PREFIX_PATH|PYTHONPATH|VIRTUAL_ENV|LANG|LC_ALL|TERM|PATH")
_SECRET_NAME = re.compile(r"TOKEN|KEY|SECRET|PASS", re.IGNORECASE)
_CREDENTIALS = re.compile(r"(?<=//)[^/@\s]+@")
_SECRET_VALUE = re.compile(r"((?:token|key|password|passwd|secret)=)[^&\s]+", re.IGNORECASE)
_USER = re.compile(r"(/home/|/Users/|\\Users\\)[^/\\:\s]+")


def versions() -> dict[str, str]:
    """Return the installed versions of the libraries that pyros1 and its extras use: name -> version or ``-``."""
    found = {}
    for name in (*_LIBRARIES, *_LIBRARIES_WITHOUT_ROS):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "-"
    return found


def without_secrets(text: str, home: str = "") -> str:
    """Return a text without passwords and tokens of addresses, and without the names of users in paths.

    Args:
        text: any text.
        home: the user's folder, which becomes ``~``.
    """
    if len(home) > 1:
        text = re.sub(rf"{re.escape(home)}(?![\w.-])", "~", text)
    text = _USER.sub(r"\1...", text)
    return _SECRET_VALUE.sub(r"\1...", _CREDENTIALS.sub("...@", text))


def report(
    about: Mapping[str, str],
    machine: Machine,
    system: System | None,
    types: Mapping[str, str],
    findings: Sequence[Finding],
) -> str:
    """Return the report.

    Args:
        about: lines about the machine: title -> text.
        machine: facts about this machine.
        system: facts about the running system; None: there is none, or it does not answer.
        types: topic -> type, from the master.
        findings: the problems found.
    """
    parts = [
        "# pyros1 wtf --report",
        "## Machine",
        _table(("what", "value"), [*about.items(), *_machine(machine)]),
        "## Findings",
        "\n".join(_findings(findings)) or "None.",
        "## Running system",
        *(_system(system, types) if system else ["No master answers."]),
    ]
    return without_secrets("\n\n".join(parts), machine.environ.get("HOME", "")) + "\n"


def _machine(machine: Machine) -> Iterator[tuple[str, str]]:
    yield "interfaces", ", ".join(machine.interfaces)
    for name, addresses in machine.resolved.items():
        yield f"the name {name}", ", ".join(addresses) if addresses else "has no address"
    for disk in machine.disks:
        yield f"disk of {disk.folder}", f"{disk.free / 1e9:.1f} of {disk.total / 1e9:.1f} GB free"
    yield "masters here", ", ".join(machine.masters) or "none"
    for name, value in sorted(machine.environ.items()):
        if _READ.fullmatch(name):
            yield name, "..." if _SECRET_NAME.search(name) else value


def _findings(findings: Iterable[Finding]) -> Iterator[str]:
    for finding in findings:
        yield f"- **{finding.severity}** ({finding.kind}): {one_line(finding.text)}"
        yield from (f"  - {one_line(item)}" for item in finding.items[:ROWS])
        yield f"  - cure: {one_line(finding.cure)}"


def _system(system: System, types: Mapping[str, str]) -> Iterator[str]:
    state = system.state
    yield f"Master {system.master_uri}; /use_sim_time is {system.use_sim_time}."
    nodes = [(name, node.uri, _answer(node), str(len(node.connections))) for name, node in sorted(system.nodes.items())]
    yield _table(("node", "address", "answer", "connections"), nodes)
    topics = sorted({*state.publishers, *state.subscribers})
    ends = (state.publishers, state.subscribers)
    rows = [(topic, types.get(topic, "?"), *(", ".join(each.get(topic, [])) for each in ends)) for topic in topics]
    yield _table(("topic", "type", "publishers", "subscribers"), rows)
    rows = [(name, ", ".join(providers)) for name, providers in sorted(state.services.items())]
    rows = [
        row for row in rows if not row[0].endswith(("/get_loggers", "/set_logger_level"))
    ]  # each roscpp node has them
    yield _table(("service", "node"), rows) if rows else "No services but those of loggers."


def _answer(node: NodeFacts) -> str:
    if node.failure:
        return f"none: {node.failure.text}"
    return "yes" if node.clock_offset is None else f"yes; its clock is {node.clock_offset:+.3f} s off"


def _table(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [titles, ["---"] * len(titles), *rows[:ROWS]]
    text = "\n".join(f"| {' | '.join(_cell(cell) for cell in line)} |" for line in lines)
    return text if len(rows) <= ROWS else f"{text}\n\n... and {len(rows) - ROWS} more."


def _cell(text: str) -> str:
    return one_line(text).replace("|", "\\|")
