"""A look before anything is inferred: settings for an unknown record, and what a folder holds.

Here, and only here, it is guessed: what an unknown file looks like becomes a proposal, confirmed by
reading. A folder is read as it would be later, and sorted into what is accepted and what is not.
"""
