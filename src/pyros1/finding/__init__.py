"""Where packages, definitions and executables are on this machine; manifests; templates of new packages."""
