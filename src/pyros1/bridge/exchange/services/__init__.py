"""Calls of services across sites: values in, actions out. No I/O."""
