"""A robot and its world with masses, forces and contacts, in MuJoCo; `plant.mujoco` is the plant.

`model` builds the model from a robot's description, with one of the kinds of `base`; `servos` move
its joints and break them, and `contacts` notes what touches what.
"""
