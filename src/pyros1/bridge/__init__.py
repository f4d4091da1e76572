"""Sites: several masters, each with its own nodes, that exchange topics over networks that lose, delay and break."""
