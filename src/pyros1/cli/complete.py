"""``pyros1 __complete``: candidates for the word at the cursor, for the completion of shells.

It prints no errors, waits only a moment for the master, and imports only what the kind of candidate needs.
"""

from __future__ import annotations

from collections.abc import Callable

from pyros1.cli import registry
from pyros1.cli.clean_output import data_stream
from pyros1.cli.complete_line import Line
from pyros1.ground.terminal_text import lines

_SAFE = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./:=@%,~")


_FILES = ("bag", "dir", "file", "output")
"""Words in the name of an option, or of its value, if the value is a file."""
_KINDS = ("example",)
"""Names of options that are also names of kinds."""


def candidates(line: Line) -> list[str]:
    """Return the candidates for the word at the cursor: whole words, unquoted."""
    if not line.command:
        return sorted([*registry.commands(), "help"])
    if line.token.startswith("-"):
        return _options(line)
    if line.verbs and not line.verb:
        return [] if line.words else line.verbs
    option = line.option
    if option is None:
        kind = registry.completes(line.command, line.verb, len(line.given_arguments))
    elif "choices" in option.settings:
        return [str(choice) for choice in option.settings["choices"]]
    elif option.dest in _KINDS:
        kind = option.dest
    else:
        about = f"{option.dest} {option.settings.get('metavar', '')}".lower()
        kind = "file" if any(word in about for word in _FILES) else ""
    if not kind:
        return []
    from pyros1.cli import complete_values  # noqa: PLC0415 - not needed for verbs

    makers: dict[str, Callable[[Line], list[str]]] = complete_values.KINDS
    return [each for part in kind.split("|") for each in makers[part](line)]


def _options(line: Line) -> list[str]:
    """Return the options of a command or verb."""
    verb = registry.load_verb(line.command, line.verb) if line.verb else registry.load_command(line.command).verb
    if verb is None:
        return ["--help"]
    return sorted({"--help", "-h", *(name for option in verb.options if not option.hidden for name in option.names)})


def main(argv: list[str]) -> int:
    """Print candidates.

    Args:
        argv: the shell; its word separators (``COMP_WORDBREAKS`` of bash, else empty); the index of the word at the
            cursor; the words of the command line.

    Returns:
        The exit code, 0.
    """
    try:
        shell, breaks, index, *words = argv
        words = words[: int(index) + 1] + [""] * (int(index) + 1 - len(words))
        if ":" in breaks:
            words = join_parts(words)
        token = words[-1]
        lead = token[:1] if token[:1] in ("'", '"') else ""
        line = Line([*words[:-1], token[len(lead) :]], one_line=shell == "fish")
        found = [each for each in candidates(line) if each.startswith(line.token) and each == lines(each) != ""]
    except Exception:  # noqa: BLE001 - errors must not appear in a line that is being typed
        return 0
    start = max((line.token.rfind(each) for each in ":=" if each in breaks), default=-1) + 1
    out = data_stream()
    for each in dict.fromkeys(found):
        text = each[start:] if " " not in each else each
        text = text.replace("\n", " ") if shell == "fish" else quote(text, lead)
        out.write(text + ("\n" if shell == "fish" else "\0"))
    out.flush()
    return 0


def join_parts(words: list[str]) -> list[str]:
    """Undo bash's splitting of words at colons and equals signs: ``rate`` ``:=`` ``5`` is one word in ROS."""
    result: list[str] = []
    glue = False
    for word in words:
        word_parts = bool(word) and not word.strip(":=")
        if result and (word_parts or glue) and len(result) > 1:
            result[-1] += word
        else:
            result.append(word)
        glue = word_parts
    return result


def quote(text: str, lead: str = "") -> str:
    """Return a word quoted for a shell, in double quotes if necessary.

    Args:
        text: the word.
        lead: the quotation mark that was already typed.
    """
    if not lead and _SAFE.issuperset(text):
        return text
    if lead == "'":
        return "'" + text.replace("'", "'\\''") + "'"
    for each in '\\"$`':
        text = text.replace(each, "\\" + each)
    return f'"{text}"'
