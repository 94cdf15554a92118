"""From the travel curve of a circuit breaker to the state of its drive, with its uncertainty.

Three wings, and what joins them; docs/development.md is the map.

    reading    from any file of an instrument to measured quantities of a motion
    drive      networks of families of drives, answers, lives, fleets
    paper      the paper's workflow: posteriors of its model, judged exactly

    common, shipped, quantities, networks    what all stand on
    mechanism                                the model of a drive, of both upper wings
    configuration, workflow                  settings; rules and scripts
    figures, cli                             data in, figures out; the command ``breaker``

A name is imported from the module that defines it. The workflow is in ``Snakefile`` and
``workflow``.
"""

__all__ = ["DISTRIBUTION", "__version__"]

DISTRIBUTION = "breaker-drive"
"""What pip calls the package; on the package index ``breaker`` is another project."""

__version__ = "0.1.0"
