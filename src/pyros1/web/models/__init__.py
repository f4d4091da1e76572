"""Data for the tables of the page: forms of messages, parameters, goals (pure); publishing at a rate."""
