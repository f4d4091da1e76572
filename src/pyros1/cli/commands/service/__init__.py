"""``pyros1 service``: lists, inspects and calls services, like rosservice (L76-L79)."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "service",
    "list, inspect and call services",
    group="inspect",
    stock="rosservice",
    heading="Commands:",
    row="\t{program} {name}\t{about}",
    footer="\nType {program} <command> -h for more detailed usage, e.g. '{program} call -h'\n",
    error_exit_code=2,
)
