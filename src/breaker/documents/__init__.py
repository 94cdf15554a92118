"""A document on a drive or a file: as text for a terminal, as HTML, and as a PDF of that.

The parts of a document hold words; a renderer adds none.
"""
