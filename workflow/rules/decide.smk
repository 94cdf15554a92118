"""A life in the drive's own curves: what has changed since new, limits, decisions.

Needs the records of all operations, and networks that ship. Goes on with a life when operations are
appended. Makes the tables of decisions, limits and changes, the figures of
the life, and the first page of the report.
"""


rule life:
    """The path of a drive in its own curves, its changes, and what is known of every limit."""
    input:
        **{motion: curves_of(motion) for motion in MOTIONS},
    output:
        directory("results/life.zarr"),
    log:
        "logs/life.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        motions=MOTIONS,
        events=lambda wildcards: known()[0],
        conditions=lambda wildcards: known()[1],
        more_events=config["endurance"]["events"],
        limits=config["limits"],
        speeds=SPEEDS,
        wear_model=config["wear_model"],
        misfit_p_value=config["endurance"]["misfit_p_value"],
        checkpoint=placed("checkpoints/life.npz"),
    script:
        "../scripts/life.py"


rule decide:
    """How the drive stands to its limits, and what to do: every operation, and the first page."""
    input:
        **{motion: curves_of(motion) for motion in MOTIONS},
        life="results/life.zarr",
    output:
        standing=directory("results/standing.zarr"),
        decisions=page(
            "results/decisions.csv", "0 Verdict", "table of decisions", "decisions_table"
        ),
        limits=page("results/limits.csv", "0 Verdict", "table of limits", "limits_table"),
        changes=page("results/changes.csv", "0 Verdict", "table of changes", "changes_table"),
        words="results/verdict.json",
    log:
        "logs/decide.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        motions=MOTIONS,
        planning=config["planning"],
        advice=config["advice"],
    script:
        "../scripts/decide.py"


STANDING = {"life": "results/life.zarr", "standing": "results/standing.zarr"}

# The picture of the first page: how each limit stands.
figure("verdict", "0 Verdict", of="", words="results/verdict.json", **STANDING)


rule first_page:
    """What the report opens on: sentences, the table of limits and the picture."""
    input:
        words="results/verdict.json",
        figure="figures/verdict.png",
    output:
        "results/first_page.html",
    log:
        "logs/first_page.log",
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/first_page.py"


# Probability of each limit and its state, over the operations.
figure("health", "6 Decisions", of="", within="health", **STANDING)

# What a service costs by its operation.
figure(
    "service_cost",
    "6 Decisions",
    of="",
    within="service_cost",
    standing="results/standing.zarr",
)

# The path of the wear and its changes.
figure(
    "changepoint",
    "6 Decisions",
    label="change points",
    of="",
    within="changepoint",
    life="results/life.zarr",
)

# The remaining life of each limit, over the operations.
figure(
    "remaining_life",
    "6 Decisions",
    of="",
    params={"limits": config["limits"], "motions": MOTIONS, "speeds": SPEEDS},
    truth=TRUTH,
    **STANDING,
)

# The changes of the parameters since new.
figure("changes", "6 Decisions", of="", life="results/life.zarr", truth=TRUTH)
