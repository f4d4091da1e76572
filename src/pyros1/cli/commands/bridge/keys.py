"""``bridge keys``: makes the keys by which sites prove their names to each other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Option, Verb
from pyros1.ground.terminal_text import one_line


def run(invocation: Invocation, options: Any, args: list[str]) -> int | None:
    """Make the keys, and say what to do with them."""
    if len(args) < 2:
        raise UsageError("name a folder for the keys, and the sites")
    from pyros1.bridge.names import SiteNameError, site_of_key_name  # noqa: PLC0415
    from pyros1.bridge.transport.certificates import KeysError, make_keys  # noqa: PLC0415

    folder, *words = args
    hosts: dict[str, list[str]] = {}
    for word in words:
        site, equals, names = word.partition("=")
        if site in hosts:
            raise CommandError(f"site {one_line(site)} is named twice", 2)
        hosts[site] = names.split(",") if equals else []
    try:
        folders = make_keys(Path(folder).expanduser(), hosts, options.days)
    except (KeysError, SiteNameError) as error:
        raise CommandError(str(error)) from None
    for each in folders:
        names = ", ".join(hosts[each.name])
        site = site_of_key_name(each.name)
        print(f"{one_line(str(each))}: the keys of site {site}" + f", to which others connect at {names}" * bool(names))
        if site != each.name:
            print(
                f"To shut the older keys of {site} out, write {each.name} in place of them under --sites or `sites` "
                "where others connect, and start these bridges and routers again."
            )
    print(
        "Copy each folder to its site, as a whole, and start the bridge there with --keys FOLDER.\n"
        f"Keep {one_line(str(folders[0].parent / 'ca'))} where no site can read it: it makes keys for any name."
    )
    return None


VERB = Verb(
    "keys",
    "make the keys by which sites prove their names to each other",
    Option(
        "--days",
        type="int",
        default=3650,
        metavar="DAYS",
        help="how long the keys are valid (default: 3650, ten years)",
    ),
    Argument("folder", help="where to put them; more sites can be added later"),
    Argument(
        "site",
        repeatable=True,
        help="a site; if others connect to it, with its host names and addresses: base=HOST,HOST; red-2 for newer "
        "keys of red",
    ),
    description="Make keys and certificates for sites: a folder for each site, and one for the authority that "
    "issues them, also for sites added later. If other sites connect to a site, write its host names and addresses "
    "after its name: base=base.example,10.0.0.1.",
    examples=[
        ("site_keys red-2", "new keys of a robot whose old ones are to be shut out"),
        ("site_keys red green base=base.example,10.0.0.1", "keys of two robots, and of a base to which they connect"),
    ],
    stock="",
    run=run,
)
