"""The page of ``breaker view``: a list of inspections, and each on one screen, in the browser.

``server`` answers requests, ``session`` reads and judges, ``catalogue`` lists, ``choices`` reads
addresses and import settings, ``curves`` draws, ``values`` fills the table, ``types`` keeps limits.
"""
