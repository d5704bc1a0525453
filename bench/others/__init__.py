"""The same robot's traffic on what users would else pick: dora-rs, pyzmq, Cyclone DDS, SPADE."""
