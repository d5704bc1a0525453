"""Starting, watching and judging a run."""
