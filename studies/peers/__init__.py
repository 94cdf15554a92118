"""Other tools and this one with equal budgets: ``python -m studies.peers``."""
