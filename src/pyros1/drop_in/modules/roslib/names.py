"""Names in the graph, and names of message and service types."""

from __future__ import annotations

from genmsg.names import (
    BASE_RESOURCE_NAME_LEGAL_CHARS_P,
    PRN_SEPARATOR,
    RESOURCE_NAME_LEGAL_CHARS_P,
    is_legal_resource_base_name,
    is_legal_resource_name,
    package_resource_name,
    resource_name,
    resource_name_base,
    resource_name_package,
)
from rosgraph.names import (
    ANYTYPE,
    BASE_NAME_LEGAL_CHARS_P,
    GLOBALNS,
    NAME_LEGAL_CHARS_P,
    PRIV_NAME,
    REMAP,
    SEP,
    anonymous_name,
    canonicalize_name,
    get_ros_namespace,
    is_global,
    is_legal_base_name,
    is_legal_name,
    is_private,
    isstring,
    load_mappings,
    make_caller_id,
    make_global_ns,
    namespace,
    ns_join,
    resolve_name,
)

from pyros1.drop_in.module_attributes import module_getattr

TYPE_SEPARATOR = "/"

__getattr__ = module_getattr(__name__)
