"""From the travel curve of a circuit breaker to the state of its drive, with its uncertainty.

docs/development.md is the map.

    model, networks           the drive of the paper; networks that know nothing of drives
    paper                     the paper's workflow: posteriors of its model, judged exactly
    reading                   from any file of an instrument to measured quantities of a motion
    drive                     networks of families of drives, answers, lives, fleets
    common, shipped           what all stand on; data and trained networks
    configuration, workflow   settings; what rules and scripts share
    figures, app, cli         figures, the page in the browser, the command ``breaker``

A name is imported from the module that defines it. The workflow is in ``Snakefile`` and
``workflow``.
"""

__all__ = ["DISTRIBUTION", "__version__"]

DISTRIBUTION = "breaker-drive"
"""What pip calls the package; on the package index ``breaker`` is another project."""

__version__ = "0.1.0"
