"""Message classes from definitions, from before genpy was a package."""

from genpy.dynamic import generate_dynamic

from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)
