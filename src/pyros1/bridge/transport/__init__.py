"""Transports packets between sites: links, queues, threads, certificates."""
