"""From the travel curve of a circuit breaker to the state of its drive, with its uncertainty.

Rooms, each a subpackage, import only rooms of a line above their own:

    mechanism, records, networks    the drive; measured records; neural networks
    model, workflow                 the joint probability model; what rules and scripts share
    posterior, family               posteriors of single records; networks of a family of drives
    validation, wear, typical       checks on known truth; a life followed; typical drives
    decisions                       how a drive stands to its limits, and what to do
    answers                         what one call infers of a drive, judged and put into words
    synthetic, figures              simulated drives and lives; data in, figures out

The command ``breaker`` is in ``breaker.cli``. The workflow is in ``Snakefile`` and ``workflow``.
"""

__all__ = ["DISTRIBUTION", "__version__"]

DISTRIBUTION = "breaker-drive"
"""What pip calls the package; on the package index ``breaker`` is another project."""

__version__ = "0.1.0"
