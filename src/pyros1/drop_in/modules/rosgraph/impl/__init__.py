"""Views of the graph."""

from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)
