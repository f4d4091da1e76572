"""All commands of ``pyros1``. Each is a module or a folder, see `pyros1.cli.records`."""
