#!/usr/bin/env python3
"""See `pyros1 tf echo -h`."""

import sys

from pyros1.cli.main import entry

sys.exit(entry(["pyros1", "tf", "echo", "--tf2", *sys.argv[1:]], alone=True))
