"""What travels between processes: keys, messages, the bus, and who is obeyed."""
