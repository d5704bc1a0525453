"""What MSMA relies on beyond Zenoh's documented interface, each with a working fallback."""
