"""The page of ``breaker view``: a list of inspections, and a screen for each, in the browser.

``server`` receives requests, ``views`` answers them, ``session`` reads inspections, ``catalogue``
makes the list, ``choices`` reads addresses and import settings, ``curves`` returns the curves to
draw, and ``types`` writes limits. Values, limits, changes and remarks are those of the report.
"""
