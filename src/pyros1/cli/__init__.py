"""Commands: each module parses its arguments, calls the library and prints. Nothing else in pyros1 prints."""
