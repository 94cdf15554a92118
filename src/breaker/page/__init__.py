"""The page of ``breaker view``: a list of inspections, and a screen for each, in the browser.

``server`` receives requests, ``views`` answers them, ``session`` reads and judges inspections,
``catalogue`` makes the list, ``choices`` reads addresses and import settings, ``curves`` returns
the curves to draw, ``values`` fills the table, and ``types`` writes limits.
"""
