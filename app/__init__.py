"""Command line and Session, the one place where the flow is wired."""
