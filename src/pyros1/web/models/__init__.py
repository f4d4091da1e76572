"""What the tables of the page show and send: forms of messages, parameters, goals (pure); publishing at a rate."""
