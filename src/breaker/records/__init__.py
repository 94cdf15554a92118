"""Read records from any file of an instrument, and measure the quantities of a motion.

This package works without a model of the drive and without torch.
"""
