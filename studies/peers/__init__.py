"""Other tools for the same task, beside this one: ``python -m studies.peers``."""
