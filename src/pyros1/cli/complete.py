"""``pyros1 __complete``: prints candidates for the word at the cursor, for completion in shells.

This command prints no errors, waits only briefly for the master, and imports only what the requested kinds of
candidates need.
"""

from __future__ import annotations

from collections.abc import Callable

from pyros1.cli import registry
from pyros1.cli.clean_output import data_stream
from pyros1.cli.complete_line import CommandLine
from pyros1.ground.terminal_text import lines

_UNQUOTED_CHARACTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./:=@%,~")


_FILE_WORDS = ("bag", "dir", "file", "output")
"""Words in the name of an option, or of its value, that mark the value as a file."""
_OPTION_KINDS = ("example",)
"""Options whose values are completed. The name of such an option is a key of `complete_values.PROVIDERS_BY_KIND`."""


def candidates(line: CommandLine) -> list[str]:
    """Return the candidates for the word at the cursor, as complete unquoted words."""
    if not line.command:
        return sorted([*registry.commands(), "help"])
    if line.token.startswith("-"):
        return _option_names(line)
    if line.verbs and not line.verb:
        return [] if line.words else line.verbs
    option = line.option
    if option is None:
        kinds = registry.completion_kinds(line.command, line.verb, len(line.positional_arguments))
    elif "choices" in option.settings:
        return [str(choice) for choice in option.settings["choices"]]
    elif option.dest in _OPTION_KINDS:
        kinds = option.dest
    else:
        description = f"{option.dest} {option.settings.get('metavar', '')}".lower()
        kinds = "file" if any(word in description for word in _FILE_WORDS) else ""
    if not kinds:
        return []
    from pyros1.cli import complete_values  # noqa: PLC0415 - not needed for verbs

    providers: dict[str, Callable[[CommandLine], list[str]]] = complete_values.PROVIDERS_BY_KIND
    return [candidate for kind in kinds.split("|") for candidate in providers[kind](line)]


def _option_names(line: CommandLine) -> list[str]:
    """Return the option names of the verb or, if the command has no verbs, of the command."""
    verb = registry.load_verb(line.command, line.verb) if line.verb else registry.load_command(line.command).verb
    if verb is None:
        return ["--help"]
    return sorted({"--help", "-h", *(name for option in verb.options if not option.hidden for name in option.names)})


def main(argv: list[str]) -> int:
    """Print the candidates for the word at the cursor.

    Args:
        argv: the shell's name; the characters at which the shell splits words (bash's ``COMP_WORDBREAKS``, empty for
            other shells); the index of the word at the cursor; and the words of the command line.

    Returns:
        The exit code, 0.
    """
    try:
        shell, separators, index, *words = argv
        words = words[: int(index) + 1] + [""] * (int(index) + 1 - len(words))
        if ":" in separators:
            words = join_split_words(words)
        token = words[-1]
        quotation_mark = token[:1] if token[:1] in ("'", '"') else ""
        line = CommandLine([*words[:-1], token[len(quotation_mark) :]], one_line=shell == "fish")
        matching = [
            candidate
            for candidate in candidates(line)
            if candidate.startswith(line.token) and candidate == lines(candidate) != ""
        ]
    except Exception:  # noqa: BLE001 - errors must not appear while the user is typing
        return 0
    suffix_start = max((line.token.rfind(separator) for separator in ":=" if separator in separators), default=-1) + 1
    out = data_stream()
    for candidate in dict.fromkeys(matching):
        text = candidate[suffix_start:] if " " not in candidate else candidate
        text = text.replace("\n", " ") if shell == "fish" else quote(text, quotation_mark)
        out.write(text + ("\n" if shell == "fish" else "\0"))
    out.flush()
    return 0


def join_split_words(words: list[str]) -> list[str]:
    """Join words that bash has split at colons and equals signs, such as ``rate``, ``:=`` and ``5`` for ``rate:=5``."""
    result: list[str] = []
    joins_next = False
    for word in words:
        is_separator = bool(word) and not word.strip(":=")
        if result and (is_separator or joins_next) and len(result) > 1:
            result[-1] += word
        else:
            result.append(word)
        joins_next = is_separator
    return result


def quote(word: str, quotation_mark: str = "") -> str:
    """Quote a word for a shell if necessary, in double quotes unless another quotation mark was already typed.

    Args:
        word: the word.
        quotation_mark: the opening quotation mark if one was already typed.
    """
    if not quotation_mark and _UNQUOTED_CHARACTERS.issuperset(word):
        return word
    if quotation_mark == "'":
        return "'" + word.replace("'", "'\\''") + "'"
    for character in '\\"$`':
        word = word.replace(character, "\\" + character)
    return f'"{word}"'
