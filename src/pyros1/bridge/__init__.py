"""Sites: several masters, each with its own nodes, that exchange topics over unreliable networks."""
