"""What a run leaves behind: logs, evaluation, summary and plots."""
