"""Measured records: from columns of a file to curves on the time grid of the model.

Puts readings in mm and ms, leaves out samples that no sensor can give, finds the motion asked for
and its landmarks, and says what is doubtful; rejects a record with a reason if it cannot be used.
"""
