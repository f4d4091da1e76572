#!/usr/bin/env python3
"""One of pyros1's programs: the table in pyros1/cli/package_scripts.py says which."""

from pyros1.cli.main import run_script

run_script(__file__)
