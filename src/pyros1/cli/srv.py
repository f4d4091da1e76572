"""``pyros1 srv``: rossrv; all is in `pyros1.cli.msg`."""

from pyros1.cli.msg import main_srv as main

__all__ = ["main"]
