"""A Markdown report about the machine, the findings and the running system, for remote support.

The report contains no secrets: only environment variables that ROS reads, and no parameter values or messages.
Passwords and tokens in addresses are removed, and the user's folders appear without the user's name.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import metadata

from pyros1.doctor.facts import Machine, NodeFacts, System
from pyros1.doctor.finding import Finding
from pyros1.ground.terminal_text import one_line

MAX_ROWS = 200
"""Maximum number of rows in a table. The other rows are only counted."""
_LIBRARIES = (
    "rosbags", "defusedxml", "PyYAML", "lz4", "numpy", "xacro", "websockets", "pillow", "cbor2", "orjson", "av",
    "cryptography",
)  # fmt: skip
_OPTIONAL_LIBRARIES = ("rospkg", "catkin-pkg", "setuptools", "pip")
_VARIABLES = re.compile(
    r"ROS_\w+|ROSCONSOLE_\w+|PYROS1_\w+|CMAKE_PREFIX_PATH|PYTHONPATH|VIRTUAL_ENV|LANG|LC_ALL|TERM|PATH"
)
_SECRET_NAME = re.compile(r"TOKEN|KEY|SECRET|PASS", re.IGNORECASE)
_CREDENTIALS = re.compile(r"(?<=//)[^/@\s]+@")
_SECRET_VALUE = re.compile(r"((?:token|key|password|passwd|secret)=)[^&\s]+", re.IGNORECASE)
_USER_FOLDER = re.compile(r"(/home/|/Users/|\\Users\\)[^/\\:\s]+")


def versions() -> dict[str, str]:
    """Return the installed versions of the libraries that pyros1 and its extras use; ``-`` for each missing library."""
    version_by_library = {}
    for name in (*_LIBRARIES, *_OPTIONAL_LIBRARIES):
        try:
            version_by_library[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            version_by_library[name] = "-"
    return version_by_library


def without_secrets(text: str, home: str = "") -> str:
    """Return a string without the passwords and tokens in its addresses and the user names in its paths.

    Args:
        text: the string.
        home: the user's home folder, which is replaced with ``~``.
    """
    if len(home) > 1:
        text = re.sub(rf"{re.escape(home)}(?![\w.-])", "~", text)
    text = _USER_FOLDER.sub(r"\1...", text)
    return _SECRET_VALUE.sub(r"\1...", _CREDENTIALS.sub("...@", text))


def format_report(
    about: Mapping[str, str],
    machine: Machine,
    system: System | None,
    types: Mapping[str, str],
    findings: Sequence[Finding],
) -> str:
    """Return the report in Markdown.

    Args:
        about: additional rows about the machine, by title.
        machine: the facts about this machine.
        system: the facts about the running system; None if no master responds.
        types: the types of the topics.
        findings: the findings.
    """
    sections = [
        "# pyros1 wtf --report",
        "## Machine",
        _format_table(("what", "value"), [*about.items(), *_machine_rows(machine)]),
        "## Findings",
        "\n".join(_finding_lines(findings)) or "None.",
        "## Running system",
        *(_system_parts(system, types) if system else ["No master responds."]),
    ]
    return without_secrets("\n\n".join(sections), machine.environ.get("HOME", "")) + "\n"


def _machine_rows(machine: Machine) -> Iterator[tuple[str, str]]:
    yield "interfaces", ", ".join(machine.interfaces)
    for name, addresses in machine.resolved.items():
        yield f"the name {name}", ", ".join(addresses) if addresses else "has no address"
    for disk in machine.disks:
        yield f"disk of {disk.folder}", f"{disk.free / 1e9:.1f} of {disk.total / 1e9:.1f} GB free"
    yield "masters here", ", ".join(machine.masters) or "none"
    for name, value in sorted(machine.environ.items()):
        if _VARIABLES.fullmatch(name):
            yield name, "..." if _SECRET_NAME.search(name) else value


def _finding_lines(findings: Iterable[Finding]) -> Iterator[str]:
    for finding in findings:
        yield f"- **{finding.severity}** ({finding.kind}): {one_line(finding.text)}"
        yield from (f"  - {one_line(item)}" for item in finding.items[:MAX_ROWS])
        yield f"  - fix: {one_line(finding.fix)}"


def _system_parts(system: System, types: Mapping[str, str]) -> Iterator[str]:
    state = system.state
    yield f"Master {system.master_uri}; /use_sim_time is {system.use_sim_time}."
    nodes = [
        (name, node.uri, _response_text(node), str(len(node.connections)))
        for name, node in sorted(system.nodes.items())
    ]
    yield _format_table(("node", "address", "responds", "connections"), nodes)
    topics = sorted({*state.publishers, *state.subscribers})
    tables = (state.publishers, state.subscribers)
    rows = [(topic, types.get(topic, "?"), *(", ".join(table.get(topic, [])) for table in tables)) for topic in topics]
    yield _format_table(("topic", "type", "publishers", "subscribers"), rows)
    rows = [(name, ", ".join(providers)) for name, providers in sorted(state.services.items())]
    # Every roscpp node has services for its loggers.
    rows = [row for row in rows if not row[0].endswith(("/get_loggers", "/set_logger_level"))]
    yield _format_table(("service", "node"), rows) if rows else "No services except those of loggers."


def _response_text(node: NodeFacts) -> str:
    if node.failure:
        return f"no: {node.failure.text}"
    return "yes" if node.clock_offset is None else f"yes; its clock is {node.clock_offset:+.3f} s off"


def _format_table(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [titles, ["---"] * len(titles), *rows[:MAX_ROWS]]
    text = "\n".join(f"| {' | '.join(_format_cell(cell) for cell in line)} |" for line in lines)
    return text if len(rows) <= MAX_ROWS else f"{text}\n\n... and {len(rows) - MAX_ROWS} more."


def _format_cell(text: str) -> str:
    return one_line(text).replace("|", "\\|")
