"""md5 sums from before genmsg, which no known program asks for."""

from pyros1.drop_in.missing import missing

_WHY = "use genmsg.gentools, or a message class's _md5sum and _full_text"

__getattr__ = missing(__name__, compute_md5=_WHY, compute_full_text=_WHY, get_dependencies=_WHY)
