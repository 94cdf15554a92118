"""Records: from any file of an instrument to measured quantities of a motion.

Useful by itself: it knows no model of a drive and needs no torch.
"""
