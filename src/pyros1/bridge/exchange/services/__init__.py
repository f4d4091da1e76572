"""Service calls between sites: values in, actions out. No I/O."""
