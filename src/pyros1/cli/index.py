"""All commands and verbs, so that nothing is imported but what runs.

Made by ``python -m pyros1.cli.make_index``; do not edit. See `registry.CommandEntry` and `registry.VerbEntry`.
"""

# ruff: noqa
# fmt: off

from __future__ import annotations

from typing import Any

INDEX: dict[str, tuple[Any, ...]] = {
    'topic': (
        'topic',
        'show and use topics',
        'look',
        'rostopic',
        {},
        (),
        (),
        {
            'bw': ('topic.bw', 'display bandwidth used by topic', 'display bandwidth used by topic', False, '/topic', ('topic',), ()),
            'delay': ('topic.delay', 'display delay of topic from timestamp in header', 'display delay of topic from timestamp in header', False, '[options] /topic', ('topic',), ()),
            'echo': ('topic.echo', 'print messages to screen', 'print messages to screen', False, '[options] /topic', ('topic',), ()),
            'find': ('topic.find', 'find topics by type', 'find topics by type', False, 'msg-type', ('message',), ()),
            'hz': ('topic.hz', 'display publishing rate of topic', 'display publishing rate of topic    ', False, '[options] /topic_0 [/topic_1 [topic_2 [..]]]', ('topic+',), ()),
            'info': ('topic.info', 'print information about active topic', 'print information about active topic', False, '/topic', ('topic',), ()),
            'list': ('topic.list', 'list active topics', 'list active topics', False, '[/namespace]', ('namespace',), ()),
            'plot': ('topic.plot', 'draw numbers as curves in the terminal', 'draw numbers as curves in the terminal', True, '[options] /topic/field[:field...] ...', ('topic+',), ()),
            'pub': ('topic.pub', 'publish data to topic', 'publish data to topic', False, '/topic type [args...]', ('topic', 'topic_type', 'message_text+'), ()),
            'type': ('topic.type', 'print topic or field type', 'print topic or field type', False, 'topic_or_field', ('topic',), ()),
        },
    ),
}
