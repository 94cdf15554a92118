"""Networks trained on a family of rich drives, read without torch: levels, and changes.

``open_network`` reads one; ``NormalisedRecords`` is what networks see of records.
"""
