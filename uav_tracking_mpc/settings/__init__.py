"""Parameters described once, and configurations."""
