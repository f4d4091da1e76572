"""Creates message classes from definitions; this module is older than the package genpy."""

from genpy.dynamic import generate_dynamic

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)
