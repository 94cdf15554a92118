"""Training of a family's networks: its bank, rows of records, and the density that is trained.

The only room of this wing that needs torch and the paper's trainer.
"""
