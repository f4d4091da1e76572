"""Addresses and connection headers; this module is older than rosgraph."""

from rosgraph.network import (
    ROS_HOSTNAME,
    ROS_IP,
    SIOCGIFADDR,
    SIOCGIFCONF,
    ROSHandshakeException,
    create_local_xmlrpc_uri,
    decode_ros_handshake_header,
    encode_ros_handshake_header,
    get_address_override,
    get_bind_address,
    get_host_name,
    get_local_address,
    get_local_addresses,
    is_local_address,
    parse_http_host_and_port,
    python3,
    read_ros_handshake_header,
    write_ros_handshake_header,
)

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)
