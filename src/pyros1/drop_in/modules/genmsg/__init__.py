"""genmsg, by pyros1: definitions of messages and services (https://wiki.ros.org/genmsg)."""

from genmsg.base import (
    EXT_MSG,
    EXT_SRV,
    MSG_DIR,
    SEP,
    SRV_DIR,
    InvalidMsgSpec,
    MsgGenerationException,
    log,
    log_verbose,
    plog,
)
from genmsg.gentools import compute_full_text, compute_md5, compute_md5_text
from genmsg.msg_loader import MsgContext, MsgNotFound, load_depends, load_msg_by_type, load_srv_by_type
from genmsg.msgs import DURATION, HEADER, TIME, Constant, Field, MsgSpec
from genmsg.names import (
    is_legal_resource_base_name,
    is_legal_resource_name,
    package_resource_name,
    resource_name,
    resource_name_base,
    resource_name_package,
)
from genmsg.srvs import SrvSpec
from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(
    __name__,
    template_tools="message classes are created when they are imported, without source files",
)
