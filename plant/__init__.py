"""The robot: its description, kinematics, faults and simulator."""
