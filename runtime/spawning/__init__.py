"""Starting and ending processes, on this host and on others."""
