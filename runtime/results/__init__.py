"""What is left of a run: logs, evaluation, summary and plots."""
