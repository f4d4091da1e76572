"""md5 sums and full texts of definitions (https://wiki.ros.org/ROS/Technical%20Overview#Message_serialization)."""

from __future__ import annotations

from genmsg.base import InvalidMsgSpec
from genmsg.msg_loader import MsgContext, load_depends
from genmsg.msgs import MsgSpec, bare_msg_type, is_builtin
from genmsg.srvs import SrvSpec
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.errors import DefinitionError
from pyros1.msgs.digest import Digests
from pyros1.msgs.spec import MessageSpec, ServiceSpec, parse_message, parse_service

__getattr__ = module_getattr(__name__)


def _digests(msg_context: MsgContext) -> Digests:
    def resolve(name: str) -> MessageSpec:
        return parse_message(name, msg_context.get_registered(name).text)

    return Digests(resolve)


def _parse(spec: MsgSpec | SrvSpec) -> MessageSpec | ServiceSpec:
    try:
        if isinstance(spec, SrvSpec):
            return parse_service(spec.full_name, spec.text)
        return parse_message(spec.full_name, spec.text)
    except DefinitionError as error:
        raise InvalidMsgSpec(str(error)) from error


def compute_md5_text(msg_context: MsgContext, spec: MsgSpec) -> str:
    """Return the text from which a message's md5 sum is computed."""
    return _digests(msg_context).md5_text(_parse(spec))


def compute_md5(msg_context: MsgContext, spec: MsgSpec | SrvSpec) -> str:
    """Return the md5 sum of a message or service, in hexadecimal digits.

    Args:
        msg_context: contains the definitions that ``spec`` uses; see `genmsg.msg_loader.load_depends`.
        spec: the definition.

    Raises:
        KeyError: a definition is not known.
    """
    return _digests(msg_context).md5(_parse(spec))


compute_md5_v2 = compute_md5


def compute_full_text(msg_context: MsgContext, spec: MsgSpec | SrvSpec) -> str:
    """Return a definition, followed by the definitions of all types that it uses, as in connection headers; see
    :func:`compute_md5`.
    """
    return _digests(msg_context).full_text(_parse(spec))


def compute_full_type_name(package_name: str, file_name: str) -> str:
    """Return the type ``package/Type`` that a file defines.

    Raises:
        MsgGenerationException: the file's name does not end in .msg or .srv.
    """
    from genmsg.base import EXT_MSG, EXT_SRV, MsgGenerationException

    for suffix in (EXT_MSG, EXT_SRV):
        if file_name.endswith(suffix):
            short = file_name[: -len(suffix)]
            return f"{package_name}/{short}"
    raise MsgGenerationException(f"Processing file: '{file_name}' - unknown file extension")
