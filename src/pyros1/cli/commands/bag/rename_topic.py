"""``bag rename-topic``: copies a bag with other topic names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.bag.edit import editing as edit
from pyros1.bag.format.reader import BagReader
from pyros1.cli.commands.bag._options import compression_options
from pyros1.cli.commands.bag._writing.files import check_different, new_file
from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.progress import Progress
from pyros1.ground.names import is_legal_name


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write a copy of a bag in which some topics are renamed."""
    if len(args) < 4 or len(args) % 2:
        raise UsageError("You must specify an in bag, an out bag, and pairs of an old and a new name.")
    source, target, *old_and_new_names = args
    check_different(source, target)
    new_names = dict(zip(old_and_new_names[::2], old_and_new_names[1::2], strict=True))
    for new_name in new_names.values():
        if not is_legal_name(new_name.rstrip("/")):
            raise CommandError(f"{new_name!r} is not a legal topic name")
    with BagReader(source) as bag:
        topics = {connection.topic for connection in bag.connections.values()}
        for old_name in new_names:
            if not any(_new_topic_name(topic, {old_name: "?"}) != topic for topic in topics):
                raise CommandError(f"{source} has no topic {old_name}{did_you_mean(old_name, topics)}")
        with new_file(target) as temporary_path, Progress(target, bag.content_size()) as progress:
            count = edit.copy(
                bag.messages(),
                temporary_path,
                compression=options.compression,
                cipher=bag.file.cipher,
                rename=lambda topic: _new_topic_name(topic, new_names),
                progress=progress,
            )
    print(f"{target}: {count} messages")


VERB = Verb(
    "rename-topic",
    "copy a bag and rename topics",
    CHUNK_LIMIT_OPTION,
    *compression_options("none"),
    Argument("INBAG", "bag"),
    Argument("OUTBAG", "file"),
    Argument("NAME", repeatable=True),
    usage="[options] INBAG OUTBAG OLD NEW [OLD NEW ...]",
    description="Rename topics. If OLD and NEW end with a slash, all topics of that namespace are renamed.",
    examples=[
        ("run.bag out.bag /scan /front/scan", "rename one topic"),
        ("run.bag out.bag /robot1/ /robot2/", "rename all topics of a namespace"),
    ],
    stock="rosrun rosbag topic_renamer.py",
    run=run,
)


def _new_topic_name(topic: str, new_names: Mapping[str, str]) -> str:
    for old_name, new_name in new_names.items():
        if topic.lstrip("/") == old_name.lstrip("/"):
            return new_name
        if old_name.endswith("/") and topic.lstrip("/").startswith(old_name.lstrip("/")):
            return new_name + topic.lstrip("/")[len(old_name.lstrip("/")) :]
    return topic
