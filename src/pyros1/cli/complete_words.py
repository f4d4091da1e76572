"""Verbs and kinds of arguments of all commands, for completion."""

from __future__ import annotations

# Kinds of the arguments in order; the last is repeated if it ends with "+". Several kinds are parted by "|".
_TOPICS = ("topic+",)
_NODES = ("node+",)
_BAGS = ("bag+",)

VERBS: dict[str, dict[str, tuple[str, ...]]] = {
    "topic": {
        "bw": _TOPICS,
        "delay": ("topic",),
        "echo": _TOPICS,
        "find": ("message",),
        "hz": _TOPICS,
        "info": ("topic",),
        "list": ("namespace",),
        "plot": _TOPICS,
        "pub": ("topic", "topic_type", "message_text"),
        "type": ("topic",),
    },
    "node": {
        "cleanup": (),
        "info": _NODES,
        "kill": _NODES,
        "list": ("namespace",),
        "machine": ("machine",),
        "ping": _NODES,
        "restart": _NODES,
        "start": _NODES,
        "status": _NODES,
        "stop": _NODES,
        "tree": ("namespace",),
    },
    "service": {
        "args": ("service",),
        "call": ("service", "request_text"),
        "find": ("service_type",),
        "info": ("service",),
        "list": ("namespace",),
        "node": ("service",),
        "type": ("service",),
        "uri": ("service",),
    },
    "param": {
        "delete": ("param",),
        "dump": ("file", "param"),
        "get": ("param",),
        "list": ("param",),
        "load": ("file", "param"),
        "set": ("param",),
    },
    "msg": {
        "info": ("message",),
        "list": (),
        "md5": ("message",),
        "package": ("package",),
        "packages": (),
        "show": ("message",),
    },
    "srv": {
        "info": ("service_type",),
        "list": (),
        "md5": ("service_type",),
        "package": ("package",),
        "packages": (),
        "show": ("service_type",),
    },
    "msg-proto": {"msg": ("message",), "srv": ("service_type",)},
    "bag": {
        "check": _BAGS,
        "compress": _BAGS,
        "decompress": _BAGS,
        "decrypt": _BAGS,
        "encrypt": _BAGS,
        "export": _BAGS,
        "filter": ("bag", "file"),
        "fix": ("bag", "file"),
        "info": _BAGS,
        "merge": _BAGS,
        "play": _BAGS,
        "record": _TOPICS,
        "reindex": _BAGS,
        "split": _BAGS,
    },
    "log": {"echo": ("node",), "get": ("node",), "list": ("node",), "set": ("node",)},
    "dynparam": {
        **dict.fromkeys(("get", "set", "set_from_parameters"), ("configurable",)),
        **dict.fromkeys(("dump", "load"), ("configurable", "file")),
        "list": (),
    },
    "tf": {
        "buffer_server": (),
        "change_notifier": (),
        "echo": ("frame", "frame"),
        "empty_listener": (),
        "monitor": ("frame", "frame"),
        "remap": (),
        "static_transform_publisher": ("",) * 6 + ("frame", "frame"),
        "tree": (),
        "view_frames": (),
    },
    "topic_tools": {
        "demux": ("topic+",),
        "drop": ("topic", "", "", "topic"),
        "mux": ("topic+",),
        "relay": ("topic", "topic"),
        "relay_field": ("topic", "topic", "message"),
        "throttle": ("throttle", "topic"),
        "transform": ("topic", "topic", "message"),
    },
}  # fmt: skip
"""Command -> verb -> kinds of its arguments."""
