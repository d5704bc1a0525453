"""Seven-way echo: the traffic of the mobile arm without its thinking, over any system."""
