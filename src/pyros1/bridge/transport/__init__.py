"""The transport of packets between sites: links, queues, threads, certificates."""
