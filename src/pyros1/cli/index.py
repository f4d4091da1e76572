"""All commands and verbs, so that nothing is imported but what runs.

Made by ``python -m pyros1.cli.make_index``; do not edit. See `registry.CommandEntry` and `registry.VerbEntry`.
"""

# ruff: noqa
# fmt: off

from __future__ import annotations

from typing import Any

INDEX: dict[str, tuple[Any, ...]] = {
    'clean': (
        'clean',
        'show and remove log files',
        'machine',
        'rosclean',
        {},
        (),
        (),
        {
            'check': ('clean.check', 'Check usage of log files', 'Check usage of log files', False, '[options]', (), ()),
            'purge': ('clean.purge', 'Remove log files', 'Remove log files', False, '[options]', (), ()),
        },
    ),
    'core': (
        'core',
        'start a master, with parameter server and rosout',
        'run',
        'roscore',
        {},
        (),
        (),
        {
        },
    ),
    'launch': (
        'launch',
        'start the nodes of a launch file',
        'run',
        'roslaunch',
        {'roslaunch-check': ('--check',), 'roslaunch-complete': ('--complete',), 'roslaunch-deps': ('--deps',), 'roslaunch-logs': ('--logs',)},
        (),
        ('package|launch_file', 'package_launch_file|launch_arg', 'launch_arg+'),
        {
        },
    ),
    'master': (
        'master',
        'start a master alone, without rosout',
        'run',
        'rosmaster',
        {},
        (),
        (),
        {
        },
    ),
    'run': (
        'run',
        'start a node of a package',
        'run',
        'rosrun',
        {},
        (),
        ('package', 'executable', 'file+'),
        {
        },
    ),
    'test': (
        'test',
        'run the tests of a launch file',
        'run',
        'rostest',
        {},
        (),
        ('package|launch_file', 'package_launch_file|launch_arg', 'launch_arg+'),
        {
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
    'version': (
        'version',
        'print versions of packages and the name of the distribution',
        'machine',
        'rosversion',
        {},
        (),
        ('package',),
        {
        },
    ),
    'wtf': (
        'wtf',
        'find what is wrong with this machine and the running system, and the cure',
        'machine',
        'roswtf',
        {},
        ('doctor',),
        ('launch_file+',),
        {
        },
    ),
}
