"""Performance: measured in processes as users run them, beside what they would else pick."""
