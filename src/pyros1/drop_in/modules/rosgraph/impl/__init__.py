"""The graph of nodes and topics; see `rosgraph.impl.graph`."""

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)
