"""From the travel curve of a circuit breaker to the state of its drive, with its uncertainty.

Rooms, each a subpackage, import only rooms of a line above their own:

    stores, shipped              Zarr stores; defaults and networks that ship
    mechanism, networks          the drive; neural networks
    files                        what instruments write
    records                      measured records
    model, workflow, inspection  the joint probability model; rules and scripts; unknown files
    posterior, family            posteriors by the model; networks of a family of drives
    validation, wear             checks on known truth; a life followed to decisions
    answers                      what one call tells of a drive
    fleet                        many drives side by side
    synthetic, figures           simulated drives; data in, figures out
    cli                          the command

The command ``breaker`` is in ``breaker.cli``. The workflow is in ``Snakefile`` and ``workflow``.
"""

__all__ = ["DISTRIBUTION", "__version__"]

DISTRIBUTION = "breaker-drive"
"""What pip calls the package; on the package index ``breaker`` is another project."""

__version__ = "0.1.0"
