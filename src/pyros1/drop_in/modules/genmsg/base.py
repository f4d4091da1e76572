"""Constants and exceptions of genmsg."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.drop_in.module_attributes import module_getattr

SEP = "/"
MSG_DIR = "msg"
SRV_DIR = "srv"
EXT_MSG = ".msg"
EXT_SRV = ".srv"
CONSTCHAR = "="
COMMENTCHAR = "#"
IODELIM = "---"
verbose = False

__getattr__ = module_getattr(__name__)


class InvalidMsgSpec(Exception):
    """A definition is invalid."""


class MsgGenerationException(Exception):
    """No class can be generated from a definition."""


def log(*args: Any) -> None:
    """Write values to stderr, with the name of the module."""
    print("[genmsg]", *args, file=sys.stderr)


def log_verbose(value: bool) -> None:
    """Do nothing: in stock ROS, this sets whether :func:`plog` writes anything."""


def plog(msg: str, obj: Any) -> None:
    """Do nothing: in stock ROS, this logs the steps of the generator, which pyros1 does not have."""
