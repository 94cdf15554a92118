"""From a breaker's travel curves to the physical state of its drive: the table of contents."""

import os
from pathlib import Path

from breaker.configuration import loading as configuration
from breaker.configuration.yaml_sources import ConfigurationError
from breaker.workflow import snakemake_internals
from snakemake.utils import min_version

min_version("9.14")

if gone := snakemake_internals.lacking(workflow):
    raise WorkflowError(gone)

ROOT = snakemake_internals.folder_of(workflow)
ADVANCED = os.path.relpath(ROOT / "config/advanced.yaml")  # of the code, in any --directory

try:  # Snakemake would run the code of a template; another --directory may have no defaults
    for path in (ADVANCED, "config/config.yaml"):
        if Path(path).exists():
            configuration.read(path)
except ConfigurationError as error:
    raise WorkflowError(str(error)) from None


configfile: ADVANCED
configfile: "config/config.yaml"


report: "workflow/report/workflow.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/operations.smk"
include: "workflow/rules/resources.smk"
include: "workflow/rules/figure.smk"
include: "workflow/rules/simulate.smk"
include: "workflow/rules/family.smk"
include: "workflow/rules/train.smk"
include: "workflow/rules/validate.smk"
include: "workflow/rules/correct.smk"
include: "workflow/rules/endurance.smk"
include: "workflow/rules/decide.smk"
include: "workflow/rules/numbers.smk"
include: "workflow/rules/fleet.smk"


FIGURES = [
    "prior_predictive",
    "loss",
    "sbc_reader",
    "recovery",
    "pairs",
    "posterior_predictive",
    "endurance_predictive",
    "evolution",
    "sbc",
    "contraction",
    "exactness",
    "identifiability",
]
LIFE = ["verdict", "health", "remaining_life", "changepoint", "changes"]


OF_ONE = [
    *expand("figures/{figure}_{motion}.png", figure=FIGURES, motion=MOTIONS),
    *expand(
        "results/{table}/{motion}_seed{seed}.csv",
        table=["quality", "exactness"],
        motion=MOTIONS,
        seed=SEED,
    ),
    *expand("results/endurance/{motion}.csv", motion=MOTIONS),
    *expand("figures/{figure}.png", figure=LIFE),
    *expand("results/{table}.csv", table=["decisions", "limits", "changes"]),
    "results/first_page.html",
    "results/numbers.csv",
    judged_shipped,
]


rule all:
    """Every figure of the paper, the decisions, tables, and how good the networks that ship are.

    Of several breakers: the fleet alone, which needs no training.
    """
    default_target: True
    input:
        *(FLEET if IS_FLEET else OF_ONE),


rule second_seed:
    """The quality of both motions on a second validation seed, outside of `all`."""
    input:
        expand(
            "results/quality/{motion}_seed{seed}.csv",
            motion=MOTIONS,
            seed=config["validation"]["second_seed"],
        ),


complete_rules()
