"""The state machine of a site: values in, actions out. No I/O."""
