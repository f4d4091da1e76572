"""Stock's plugin for roswtf is left out: ``pyros1 wtf`` looks for the same problems."""

raise ImportError("pyros1 has no tf.tfwtf, tf's plugin for roswtf: `pyros1 wtf` and `pyros1 tf monitor` check frames")
