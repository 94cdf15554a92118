"""Training of a family's networks. The only room of this wing that needs torch and the paper's
trainer.
"""
