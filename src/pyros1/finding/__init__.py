"""Finds packages, definitions and executables; reads manifests; creates new packages."""
