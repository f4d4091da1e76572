"""``python -m pyros1``: the same as the ``pyros1`` command."""

from __future__ import annotations

import sys

from pyros1.cli.main import entry

sys.exit(entry())
