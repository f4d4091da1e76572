"""``pyros1 topic``: rostopic (L25-L30, L60-L69). Each verb's module is imported when it is used."""

from __future__ import annotations

from importlib import import_module

from pyros1.cli.common import Invocation, run

_VERBS = {
    "bw": ("topic_rates", "bandwidth"),
    "delay": ("topic_rates", "delay"),
    "echo": ("topic_echo", "echo"),
    "find": ("topic_list", "find"),
    "hz": ("topic_rates", "hz"),
    "info": ("topic_list", "info"),
    "list": ("topic_list", "list_topics"),
    "plot": ("topic_plot", "plot"),
    "pub": ("topic_pub", "pub"),
    "type": ("topic_list", "type_of"),
}


def usage(program: str) -> str:
    """The command list; under the stock tool's name it is that tool's."""
    more = "" if program == "rostopic" else f"\t{program} plot\tdraw numbers as curves in the terminal\n"
    return f"""{program} is a command-line tool for printing information about ROS Topics.

Commands:
\t{program} bw\tdisplay bandwidth used by topic
\t{program} delay\tdisplay delay of topic from timestamp in header
\t{program} echo\tprint messages to screen
\t{program} find\tfind topics by type
\t{program} hz\tdisplay publishing rate of topic    
\t{program} info\tprint information about active topic
\t{program} list\tlist active topics
{more}\t{program} pub\tpublish data to topic
\t{program} type\tprint topic or field type

Type {program} <command> -h for more detailed usage, e.g. '{program} echo -h'
"""  # noqa: W291 - the spaces behind "rate of topic" are stock's


def _verb(invocation: Invocation) -> int | None:
    module, function = _VERBS[invocation.verb]
    code: int | None = getattr(import_module(f"pyros1.cli.{module}"), function)(invocation)
    return code


def main(argv: list[str]) -> int:
    """Run ``topic <verb> ...``; returns the exit code."""
    return run("rostopic", argv, dict.fromkeys(_VERBS, _verb), usage)
