"""Echo of seven agents: the traffic of the mobile arm without its decisions, over any system."""
