"""Checks of a machine, its certificates and its network, before anything is started."""
