"""The nodes as processes."""
