"""Shared code of ``setup`` and ``unsetup``: detection of the calling shell, and code for bash, zsh, fish and sh.

The code saves existing functions and completions with the same names, and ``unsetup`` restores them. Plain sh cannot
print the definition of a function, so existing functions are lost there. Commands that start programs must not be
functions: a shell runs a background function in a copy of itself, and ``kill $!`` would kill that copy instead of the
program.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Option, Verb
from pyros1.cli.registry import SHELL_FUNCTIONS
from pyros1.cli.shared.argparsing import add_options_and_arguments, make_parser
from pyros1.finding.python_modules import DROP_IN_START


@dataclass(frozen=True)
class CompletedNames:
    """The programs and functions whose arguments are completed."""

    programs: list[str]

    def __str__(self) -> str:
        return " ".join(sorted({*self.programs, *SHELL_FUNCTIONS}))


@dataclass(frozen=True)
class Shell:
    """The code that sets up a kind of shell, and reverts the setup.

    Attributes:
        setup_code: code that sets up the shell, with placeholders such as ``@@bin`` and ``@@names``.
        undo_code: code that reverts the setup if the shell was set up, and otherwise runs ``@@otherwise``.
        source_format: format string of the line that sources a command's output; ``{}`` is replaced by the command.
    """

    setup_code: str
    undo_code: str
    source_format: str

    def setup(self, folder: str, names: CompletedNames) -> str:
        """Return the code that sets up the shell.

        Args:
            folder: the folder that contains the programs.
            names: the programs and functions to complete.
        """
        functions = " ".join(SHELL_FUNCTIONS)
        undo = self.undo_code.replace("@@otherwise", "true")
        substitutions = {"bin": shlex.quote(folder), "names": str(names), "functions": functions, "undo": undo}
        substitutions |= {"modules": shlex.quote(DROP_IN_START), "python": shlex.quote(sys.executable)}
        return _AtTemplate(self.setup_code).substitute(substitutions).lstrip()

    def undo(self) -> str:
        """Return the code that reverts the setup, or prints that the shell was not set up."""
        return self.undo_code.replace("@@otherwise", "echo 'pyros1: this shell was not set up' >&2")


class _AtTemplate(Template):
    delimiter = "@@"


_BASH = Shell(
    r"""
# pyros1 for bash; `source <(pyros1 unsetup)` undoes it.
@@undo
_pyros1_bin=@@bin
_pyros1_names='@@names'
_pyros1_saved="$(declare -f @@functions; complete -p $_pyros1_names 2>/dev/null)" || true
case ":$PATH:" in
  *:"$_pyros1_bin":*) ;;
  *) PATH="$_pyros1_bin:$PATH" ;;
esac
_pyros1_modules=@@modules
case ":${PYTHONPATH-}:" in
  *:"$_pyros1_modules":*) ;;
  *) export PYTHONPATH="$_pyros1_modules${PYTHONPATH:+:$PYTHONPATH}" ;;
esac
export PYROS1_PYTHON=@@python
function roscd {
  local folder
  folder="$(command pyros1 pkg cd "$@")" && cd "$folder"
}
function rospd {
  if [ $# -eq 0 ]; then pushd; return; fi
  case "$1" in
    [0-9]) pushd "+$1" ;;
    *) local folder; folder="$(command pyros1 pkg cd "$@")" && pushd "$folder" ;;
  esac
}
function rosd { dirs -v; }
function _pyros1_complete {
  local each
  COMPREPLY=()
  while IFS= read -r -d '' each; do COMPREPLY+=("$each"); done < <(
    command pyros1 __complete bash "$COMP_WORDBREAKS" "$COMP_CWORD" "${COMP_WORDS[@]}" 2>/dev/null
  )
  case "${COMPREPLY[0]-}" in
    */ | *=) compopt -o nospace 2>/dev/null || true ;;
  esac
}
function _pyros1_undo {
  local path=":$PATH:" saved="$_pyros1_saved"
  path="${path/:"$_pyros1_bin":/:}"
  path="${path#:}"
  PATH="${path%:}"
  path=":${PYTHONPATH-}:"
  path="${path/:"$_pyros1_modules":/:}"
  path="${path#:}"
  PYTHONPATH="${path%:}"
  [ -n "$PYTHONPATH" ] || unset PYTHONPATH
  complete -r $_pyros1_names 2>/dev/null
  unset -f @@functions _pyros1_complete _pyros1_undo
  unset _pyros1_bin _pyros1_modules _pyros1_names _pyros1_saved PYROS1_PYTHON
  eval "$saved"
  hash -r
}
complete -F _pyros1_complete $_pyros1_names
hash -r
""",
    "if declare -F _pyros1_undo >/dev/null; then _pyros1_undo; else @@otherwise; fi",
    "source <({})",
)

_ZSH = Shell(
    r"""
# pyros1 for zsh; `source <(pyros1 unsetup)` undoes it.
@@undo
typeset -g _pyros1_bin=@@bin
typeset -ga _pyros1_names=(@@names)
typeset -g _pyros1_saved="$(functions @@functions)"
() {
  local each
  (( $+functions[compdef] )) || return 0
  for each in $_pyros1_names; do
    [[ -z ${_comps[$each]-} ]] || _pyros1_saved+=$'\n'"compdef ${(q)_comps[$each]} $each"
  done
}
(( ${path[(Ie)$_pyros1_bin]} )) || path=("$_pyros1_bin" "${path[@]}")
typeset -g _pyros1_modules=@@modules
case ":${PYTHONPATH-}:" in
  *:"$_pyros1_modules":*) ;;
  *) export PYTHONPATH="$_pyros1_modules${PYTHONPATH:+:$PYTHONPATH}" ;;
esac
export PYROS1_PYTHON=@@python
function roscd {
  local folder
  folder="$(command pyros1 pkg cd "$@")" && cd "$folder"
}
function rospd {
  if (( $# == 0 )); then pushd; return; fi
  case "$1" in
    ([0-9]) pushd "+$1" ;;
    (*) local folder; folder="$(command pyros1 pkg cd "$@")" && pushd "$folder" ;;
  esac
}
function rosd { dirs -v; }
function _pyros1_complete {
  local -a found open
  found=("${(@0)$(command pyros1 __complete zsh '' $((CURRENT - 1)) "${words[@]}" 2>/dev/null)}")
  found=("${(@)found:#}")
  open=("${(@M)found:#*[/=]}")
  found=("${(@)found:#*[/=]}")
  (( $#open )) && compadd -Q -U -S '' -- "${open[@]}"
  (( $#found )) && compadd -Q -U -- "${found[@]}"
}
function _pyros1_undo {
  local saved="$_pyros1_saved"
  path=("${(@)path:#$_pyros1_bin}")
  local -a modules=("${(@s/:/)PYTHONPATH}")
  PYTHONPATH="${(j/:/)modules:#$_pyros1_modules}"
  [[ -n $PYTHONPATH ]] || unset PYTHONPATH
  (( $+functions[compdef] )) && compdef -d $_pyros1_names
  unfunction @@functions _pyros1_complete _pyros1_undo
  unset _pyros1_bin _pyros1_modules _pyros1_names _pyros1_saved PYROS1_PYTHON
  eval "$saved"
  rehash
}
(( $+functions[compdef] )) && compdef _pyros1_complete $_pyros1_names
rehash
""",
    "if (( $+functions[_pyros1_undo] )); then _pyros1_undo; else @@otherwise; fi",
    "source <({})",
)

_FISH = Shell(
    r"""
# pyros1 for fish; `pyros1 unsetup | source` undoes it.
@@undo
set -g _pyros1_bin @@bin
set -g _pyros1_names @@names
set -g _pyros1_saved
for each in $_pyros1_names
    set -a _pyros1_saved (complete -c $each | string collect)
end
for each in @@functions
    functions -q $each; and functions -c $each _pyros1_saved_$each
end
contains -- $_pyros1_bin $PATH; or set -gx PATH $_pyros1_bin $PATH
set -g _pyros1_modules @@modules
contains -- $_pyros1_modules (string split : -- $PYTHONPATH)
or set -gx PYTHONPATH (string join : -- $_pyros1_modules (string split : -- $PYTHONPATH))
set -gx PYROS1_PYTHON @@python
function roscd
    set -l folder (command pyros1 pkg cd $argv); and cd $folder
end
function rospd
    if test (count $argv) -eq 0
        pushd
    else if string match -qr '^[0-9]$' -- $argv[1]
        pushd +$argv[1]
    else
        set -l folder (command pyros1 pkg cd $argv); and pushd $folder
    end
end
function rosd
    dirs
end
function _pyros1_complete
    set -l words (commandline -opc) (commandline -ct)
    command pyros1 __complete fish '' (math (count $words) - 1) $words 2>/dev/null
end
function _pyros1_undo
    set -l rest
    for each in $PATH
        test "$each" = "$_pyros1_bin"; or set -a rest $each
    end
    set -gx PATH $rest
    set -l modules
    for each in (string split : -- $PYTHONPATH)
        test "$each" = "$_pyros1_modules"; or set -a modules $each
    end
    set -e PYTHONPATH
    set -q modules[1]; and set -gx PYTHONPATH (string join : -- $modules)
    for each in $_pyros1_names
        complete -c $each -e
    end
    for each in @@functions
        functions -e $each
        if functions -q _pyros1_saved_$each
            functions -c _pyros1_saved_$each $each
            functions -e _pyros1_saved_$each
        end
    end
    for each in $_pyros1_saved
        eval $each
    end
    set -e _pyros1_bin
    set -e _pyros1_modules
    set -e _pyros1_names
    set -e _pyros1_saved
    set -e PYROS1_PYTHON
    functions -e _pyros1_complete _pyros1_undo
end
for each in $_pyros1_names
    complete -c $each -f -a '(_pyros1_complete)'
end
""",
    "if functions -q _pyros1_undo; _pyros1_undo; else; @@otherwise; end",
    "{} | source",
)

_SH = Shell(
    r"""
# pyros1 for sh; `eval "$(pyros1 unsetup)"` undoes it.
@@undo
_pyros1_bin=@@bin
case ":$PATH:" in
  *:"$_pyros1_bin":*) ;;
  *) PATH="$_pyros1_bin:$PATH" ;;
esac
_pyros1_modules=@@modules
case ":${PYTHONPATH-}:" in
  *:"$_pyros1_modules":*) ;;
  *) PYTHONPATH="$_pyros1_modules${PYTHONPATH:+:$PYTHONPATH}" ;;
esac
PYROS1_PYTHON=@@python
export PYTHONPATH PYROS1_PYTHON
roscd() {
  _pyros1_folder="$(command pyros1 pkg cd "$@")" && cd "$_pyros1_folder"
}
_pyros1_undo() {
  PATH=":$PATH:"
  case "$PATH" in *:"$_pyros1_bin":*) PATH="${PATH%%":$_pyros1_bin:"*}:${PATH#*":$_pyros1_bin:"}" ;; esac
  PATH="${PATH#:}"
  PATH="${PATH%:}"
  PYTHONPATH=":${PYTHONPATH-}:"
  case "$PYTHONPATH" in
    *:"$_pyros1_modules":*)
      PYTHONPATH="${PYTHONPATH%%":$_pyros1_modules:"*}:${PYTHONPATH#*":$_pyros1_modules:"}" ;;
  esac
  PYTHONPATH="${PYTHONPATH#:}"
  PYTHONPATH="${PYTHONPATH%:}"
  [ -n "$PYTHONPATH" ] || unset PYTHONPATH
  unset _pyros1_bin _pyros1_modules _pyros1_folder PYROS1_PYTHON
  unset -f roscd _pyros1_undo
  hash -r
}
hash -r
""",
    "if command -v _pyros1_undo >/dev/null; then _pyros1_undo; else @@otherwise; fi",
    'eval "$({})"',
)

SHELLS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH, "sh": _SH}
"""The code for each shell."""
SH_COMPATIBLE_NAMES = frozenset({"dash", "ash", "ksh", "ksh93", "mksh", "yash", "busybox"})
"""Process names of shells that use the code for sh."""

SHELL_OPTION = Option("--shell", choices=sorted(SHELLS), help="shell to generate code for (default: the calling shell)")


def usage_examples(command: str) -> list[tuple[str, str]]:
    """Return examples for a command's help: how each shell reads the command's output, and the shell's name."""
    return [(shell.source_format.format(f"pyros1 {command}"), name) for name, shell in SHELLS.items()]


def parse_shell(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse the arguments of ``setup`` and ``unsetup``. Return the options, and an empty list of arguments."""
    parser = make_parser(invocation, verb)
    examples = "\n".join(f"  {name:5} {line}" for line, name in verb.examples)
    parser.epilog = f"how to use it:\n{examples}"
    add_options_and_arguments(parser, invocation, *verb.options)
    parsed_options, unknown_args = parser.parse_known_args(invocation.argv)
    if unknown_args:
        hint = f" (write --shell {unknown_args[0]})" if unknown_args[0] in SHELLS else ""
        parser.error(f"unrecognized arguments: {' '.join(unknown_args)}{hint}")
    return parsed_options, []


def select_shell(invocation: Invocation, options: Any) -> Shell | None:
    """Return the shell that reads the output; None if stdout is a terminal, after printing how to use the command."""
    name = options.shell or detect_shell(os.environ)
    if not sys.stdout.isatty():
        return SHELLS[name]
    usage_line = SHELLS[name].source_format.format(invocation.program)
    print(f"The output is meant to be read by the shell. In {name}, type:\n\n  {usage_line}\n")
    return None


def detect_shell(environ: Mapping[str, str]) -> str:
    """Return the name of the calling shell: the first known shell among the parent processes.

    A shell that only runs a script named pyros1 with this command's arguments is skipped.
    """
    pid = os.getppid()
    for _ in range(4):
        try:
            process_status = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
        except OSError:
            break
        shell_name = process_status[process_status.find("(") + 1 : process_status.rfind(")")].lstrip("-")
        if (shell_name in SHELLS or shell_name in SH_COMPATIBLE_NAMES) and not _runs_this_command(pid):
            return shell_name if shell_name in SHELLS else "sh"
        pid = int(process_status[process_status.rfind(")") + 2 :].split()[1])
    shell_name = os.path.basename(environ.get("SHELL", ""))
    return shell_name if shell_name in SHELLS else "bash"


def _runs_this_command(pid: int) -> bool:
    own_args = [os.fsencode(arg) for arg in sys.argv[1:]]
    try:
        command_line = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")[:-1]
    except OSError:
        return False
    script_index = len(command_line) - len(own_args) - 1
    if script_index <= 0:
        return False
    return os.path.basename(command_line[script_index]) == b"pyros1" and command_line[script_index + 1 :] == own_args
