"""Random exports of analysers, and a comparison of their readings with the truth."""
