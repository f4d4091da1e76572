"""All commands: a module or a folder each, see `pyros1.cli.records`."""
