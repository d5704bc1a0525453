"""The robot: its description and kinematics, and the plants that move it."""
