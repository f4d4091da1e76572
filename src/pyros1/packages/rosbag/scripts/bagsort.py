#!/usr/bin/env python3
"""The program of this file's name: see `pyros1 bag`."""

import sys
from pathlib import Path

from pyros1.cli.main import entry

sys.exit(entry(["pyros1", "bag", Path(__file__).name, *sys.argv[1:]]))
