"""All commands and verbs, so that nothing is imported but what runs.

Made by ``python -m pyros1.cli.make_index``; do not edit. See `registry.CommandEntry` and `registry.VerbEntry`.
"""

# ruff: noqa
# fmt: off

from __future__ import annotations

from typing import Any

INDEX: dict[str, tuple[Any, ...]] = {
    'bag': (
        'bag',
        'record, play, look at and change bags',
        'files',
        'rosbag',
        {},
        (),
        (),
        {
            'check': ('bag.check', 'see whether the messages fit the definitions of this system', 'see whether the messages fit the definitions of this system', False, 'BAG [-g RULEFILE] [EXTRARULES1 EXTRARULES2 ...]', ('bag', 'file+'), ()),
            'compress': ('bag.compress', 'compress one or more bag files', 'compress one or more bag files', False, '[options] BAGFILE1 [BAGFILE2 ...]', ('bag+',), ()),
            'decompress': ('bag.compress', 'decompress one or more bag files', 'decompress one or more bag files', False, '[options] BAGFILE1 [BAGFILE2 ...]', ('bag+',), ()),
            'decrypt': ('bag.encrypt', 'decrypt one or more bag files', 'decrypt one or more bag files', False, '[options] BAGFILE1 [BAGFILE2 ...]', ('bag+',), ()),
            'encrypt': ('bag.encrypt', 'encrypt one or more bag files', 'encrypt one or more bag files', False, '[options] BAGFILE1 [BAGFILE2 ...]', ('bag+',), ()),
            'export': ('bag.export', 'write CSV, JSON, images, videos, MCAP files or ROS 2 bags', 'write CSV, JSON, images, videos, MCAP files or ROS 2 bags', False, '[options] BAGFILE1 [BAGFILE2 ...]', ('bag+',), ()),
            'filter': ('bag.filter', 'choose messages by an expression, topics, times', 'choose messages by an expression, topics, times', False, '[options] INBAG OUTBAG [EXPRESSION]\n\nEXPRESSION is one in Python, of which the harmless part is allowed.\n\nThe following variables are available:\n * topic: name of topic\n * m: message\n * t: time of message (t.secs, t.nsecs, t.to_sec())', ('bag', 'file', ''), ()),
            'fix': ('bag.fix', 'bring the messages to the definitions of this system', 'bring the messages to the definitions of this system', False, 'INBAG OUTBAG [EXTRARULES1 EXTRARULES2 ...]', ('bag', 'file', 'file+'), ()),
            'import': ('bag.import_', 'make a bag of a ROS 2 bag or MCAP file', 'make a bag of a ROS 2 bag or MCAP file', False, '[options] SOURCE', ('file',), ()),
            'info': ('bag.info', 'summarize the contents of one or more bag files', 'summarize the contents of one or more bag files', False, '[options] BAGFILE1 [BAGFILE2 BAGFILE3 ...]', ('bag+',), ()),
            'merge': ('bag.merge', 'make one bag of several', 'make one bag of several', False, '[options] OUTBAG INBAG1 [INBAG2 ...]', ('bag', 'bag+'), ()),
            'play': ('bag.play', 'play back the contents of one or more bag files in a time-synchronized fashion', 'play back the contents of one or more bag files in a time-synchronized fashion', False, 'BAGFILE1 [BAGFILE2 BAGFILE3 ...]', ('bag+',), ()),
            'record': ('bag.record', 'record a bag file with the contents of specified topics', 'record a bag file with the contents of specified topics', False, 'TOPIC1 [TOPIC2 TOPIC3 ...]', ('topic+',), ()),
            'reindex': ('bag.reindex', 'save bags that were not closed or are damaged', 'save bags that were not closed or are damaged', False, '[options] BAGFILE1 [BAGFILE2 ...]', ('bag+',), ()),
            'rename-topic': ('bag.rename_topic', 'rename topics', 'rename topics', False, '[options] INBAG OUTBAG OLD NEW [OLD NEW ...]', ('bag', 'file', '+'), ()),
            'retime': ('bag.retime', 'move the times of messages', 'move the times of messages', False, '[options] INBAG OUTBAG', ('bag', 'file'), ()),
            'split': ('bag.split', 'make several bags of one', 'make several bags of one', False, '[options] INBAG', ('bag',), ()),
        },
    ),
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
