"""The bus between processes: topics, messages, arbitration, and the Zenoh session."""
