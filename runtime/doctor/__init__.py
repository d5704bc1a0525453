"""Checks of a machine, its keys and its network before anything is started."""
