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
    'tf': (
        'tf',
        'show and publish coordinate frames',
        'look',
        '',
        {'tf_remap': ('remap',), 'view_frames': ('view_frames',)},
        (),
        (),
        {
            'echo': ('tf.echo', 'print the transform between two frames', 'print the transform between two frames', False, 'source_frame target_frame [rate] [options]', ('frame', 'frame', ''), ('tf_echo',)),
            'monitor': ('tf.monitor', 'print how late transforms are, and how often they come', 'print how late transforms are, and how often they come', False, '[frame_a frame_b]', ('frame', 'frame'), ('tf_monitor',)),
            'tree': ('tf.tree', 'show the tree of frames with rates and ages, live', 'show the tree of frames with rates and ages, live', False, '[options]', (), ()),
            'view_frames': ('tf.view_frames', 'draw the tree of frames into a file', 'draw the tree of frames into a file', False, '[options]', (), ('view',)),
            'static_transform_publisher': ('tf.static_transform_publisher', 'publish a transform that does not change', 'publish a transform that does not change', False, 'x y z yaw pitch roll frame_id child_frame_id [period]', ('', '', '', '', '', '', 'frame', 'frame', ''), ('static',)),
            'remap': ('tf.remap', 'rename frames: from /tf_old to /tf', 'rename frames: from /tf_old to /tf', False, "[_mappings:='[{old: NAME, new: NAME}, ...]']", (), ('tf_remap',)),
            'buffer_server': ('tf.buffer_server', 'answer lookups of other nodes', 'answer lookups of other nodes', False, '[_buffer_size:=SECONDS]', (), ()),
            'change_notifier': ('tf.change_notifier', 'tell on /tf_changes when frames have moved', 'tell on /tf_changes when frames have moved', False, '[_polling_frequency:=HZ] [_translational_update_distance:=METRES]\n       [_angular_update_distance:=RADIANS]\n\nPublishes on tf_changes, latched, where a frame is in another one, when it has moved by more than the distance or has\nturned by more than twice the angle since it was last told. Looks HZ times a second (10). The parameter ~frame_pairs\nsays which frames: a list of {source_frame: NAME, target_frame: NAME}, each with distances of its own if they are not\n0.1; without it: base_link in map.', (), ('tf_change_notifier',)),
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
    'topic_tools': (
        'topic_tools',
        'forward topics',
        'look',
        '',
        {},
        (),
        (),
        {
            'relay': ('topic_tools.relay', 'publishes a topic again, by default as IN_TOPIC_relay', 'publishes a topic again, by default as IN_TOPIC_relay', False, 'IN_TOPIC [OUT_TOPIC]', ('topic', 'topic'), ()),
            'drop': ('topic_tools.drop', 'leaves out the first X of every Y messages; IN_TOPIC_drop', 'leaves out the first X of every Y messages; IN_TOPIC_drop', False, 'IN_TOPIC X Y [OUT_TOPIC]', ('topic', '', '', 'topic'), ()),
            'throttle': ('topic_tools.throttle', 'lets so many messages pass per second, or bytes within WINDOW seconds; IN_TOPIC_throttle', 'lets so many messages pass per second, or bytes within WINDOW seconds; IN_TOPIC_throttle', False, 'messages IN_TOPIC MSGS_PER_SEC [OUT_TOPIC]\n       throttle bytes IN_TOPIC BYTES_PER_SEC WINDOW [OUT_TOPIC]', ('throttle', 'topic'), ()),
            'mux': ('topic_tools.mux', 'publishes one of several topics, as the service mux/select says', 'publishes one of several topics, as the service mux/select says', False, 'OUT_TOPIC IN_TOPIC1 [IN_TOPIC2 [...]]', ('topic', 'topic+'), ()),
            'demux': ('topic_tools.demux', 'publishes on one of several topics, as demux/select says', 'publishes on one of several topics, as demux/select says', False, 'IN_TOPIC OUT_TOPIC1 [OUT_TOPIC2 [...]]', ('topic', 'topic+'), ()),
            'transform': ('topic_tools.transform', 'publishes what an expression makes of m', 'publishes what an expression makes of m', False, 'IN_TOPIC[/FIELD] OUT_TOPIC OUT_TYPE [EXPRESSION]', ('topic', 'topic', 'message', ''), ()),
            'relay_field': ('topic_tools.relay_field', 'publishes expressions of m as fields', 'publishes expressions of m as fields', False, 'IN_TOPIC[/FIELD] OUT_TOPIC OUT_TYPE YAML', ('topic', 'topic', 'message', ''), ()),
            'mux_select': ('topic_tools.mux_services', "selects the mux's input, or none: __none", "selects the mux's input, or none: __none", False, 'MUX TOPIC', ('', 'topic'), ()),
            'mux_add': ('topic_tools.mux_services', 'adds an input', 'adds an input', False, 'MUX TOPIC', ('', 'topic'), ()),
            'mux_delete': ('topic_tools.mux_services', 'deletes an input', 'deletes an input', False, 'MUX TOPIC', ('', 'topic'), ()),
            'mux_list': ('topic_tools.mux_services', 'lists the inputs', 'lists the inputs', False, 'MUX', ('',), ()),
            'demux_select': ('topic_tools.mux_services', "selects the demux's output, or none: __none", "selects the demux's output, or none: __none", False, 'DEMUX TOPIC', ('', 'topic'), ()),
            'demux_add': ('topic_tools.mux_services', 'adds an output', 'adds an output', False, 'DEMUX TOPIC', ('', 'topic'), ()),
            'demux_delete': ('topic_tools.mux_services', 'deletes an output', 'deletes an output', False, 'DEMUX TOPIC', ('', 'topic'), ()),
            'demux_list': ('topic_tools.mux_services', 'lists the outputs', 'lists the outputs', False, 'DEMUX', ('',), ()),
            'switch_mux': ('topic_tools.mux_services', "deprecated: mux_select, by the name of the mux's output", "deprecated: mux_select, by the name of the mux's output", False, 'MUXED_TOPIC SELECT_TOPIC', ('topic', 'topic'), ()),
        },
    ),
}
