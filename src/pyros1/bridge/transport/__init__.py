"""How packets travel between sites: links, queues, threads, certificates."""
