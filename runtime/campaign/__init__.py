"""Many runs of one deployment with random faults, and what they show."""
