"""What is told of a drive or a file, as one document: on a terminal, as HTML, on pages of a PDF.

The parts of a document hold words; a renderer adds none. ``figures.report`` draws the pages.
"""
