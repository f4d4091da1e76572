"""Creates message classes from definitions; this module is older than the package genpy."""

from genpy.dynamic import generate_dynamic

from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)
