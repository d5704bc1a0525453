"""Fault injection during a run: the schedule, and what carries it out."""
