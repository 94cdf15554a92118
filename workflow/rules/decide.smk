"""Decisions: limits and alarms, change points, remaining life.

Needs the exact posteriors of all operations. Goes through them in chunks: single operations are
judged by themselves, trends go on from the stored state of the chunk before, so that appended
operations run their own chunk and no other. Trends of measured quantities take seconds, and go through
all operations again. Makes the table of decisions, the figures of health,
change points and remaining life, and the first page of the report.
"""


rule condition:
    """How probably each limit is exceeded at some operations, each by its own posterior."""
    input:
        **CORRECTED,
    output:
        directory("results/condition/chunk_{chunk}.zarr"),
    log:
        "logs/condition/chunk_{chunk}.log",
    params:
        motions=MOTIONS,
        operations=operations,
        limits=config["limits"],
        speeds=SPEEDS,
    script:
        "../scripts/condition.py"


rule trend:
    """The trend of a source through some operations, from the state after those before.

    And how far the model can be trusted on the drive, by its first operations.
    """
    input:
        **CORRECTED,
        state=state_before,
        discrepancy=DISCREPANCY_OF_DRIVE,
    output:
        trend=directory("results/trend/{source}/chunk_{chunk}.zarr"),
        state=directory("results/trend/{source}/state_{chunk}.zarr"),
        trust=directory("results/trend/{source}/trust_{chunk}.zarr"),
    log:
        "logs/trend/{source}_{chunk}.log",
    params:
        seed=config["seed"],
        motions=MOTIONS,
        operations=operations,
        events=of_chunk(0),
        temperatures=of_chunk(1),
        more_events=config["endurance"]["events"],
        limits=LIMITS["model"],
        speeds=SPEEDS,
        prior=config["prior"],
        sensor=config["sensor"],
        wear_model=config["wear_model"],
        discrepancy=config["endurance"]["discrepancy"],
    script:
        "../scripts/trend.py"


rule whole_trend:
    """The trend of a source through all operations, with its changes."""
    input:
        trends=every_chunk("results/trend/{source}/chunk_{chunk}.zarr"),
        medians=medians_of_source,
    output:
        directory("results/trend/{source}.zarr"),
    log:
        "logs/whole_trend/{source}.log",
    params:
        wear_model=config["wear_model"],
    script:
        "../scripts/whole_trend.py"


rule measured_trend:
    """The trends of measured quantities that limits name, through all operations."""
    input:
        **{motion: curves_of(motion) for motion in MOTIONS},
    output:
        directory("results/trend/record.zarr"),
    log:
        "logs/measured_trend.log",
    params:
        seed=config["seed"],
        motions=MOTIONS,
        events=lambda wildcards: known()[0],
        more_events=config["endurance"]["events"],
        limits=LIMITS["record"],
        speeds=SPEEDS,
        wear_model=config["wear_model"],
    script:
        "../scripts/measured_trend.py"


rule decide:
    """What is known, what changed, what to do when: every operation, and the first page."""
    input:
        conditions=every_chunk("results/condition/chunk_{chunk}.zarr"),
        trends=expand("results/trend/{source}.zarr", source=SOURCES),
        measured=MEASURED_TREND,
        curves=expand("results/endurance/{motion}.zarr", motion=MOTIONS),
        trust=trust_of_sources,
        truth=TRUTH,
    output:
        health=directory("results/health.zarr"),
        remaining=directory("results/remaining.zarr"),
        verdict=directory("results/verdict.zarr"),
        decisions=page(
            "results/decisions.csv", "0 Verdict", "table of decisions", "decisions_table"
        ),
        alarms=page("results/alarms.csv", "0 Verdict", "table of alarms", "alarms_table"),
        trust=page("results/trust.csv", "0 Verdict", "table of trust", "trust_table"),
    log:
        "logs/decide.log",
    params:
        motions=MOTIONS,
        limits=config["limits"],
        speeds=SPEEDS,
        alarm=config["alarm"],
        wear_model=config["wear_model"],
    script:
        "../scripts/decide.py"


# The first page: is it healthy, what is wearing, how long has it left.
figure(
    "verdict",
    "0 Verdict",
    of="",
    verdict="results/verdict.zarr",
)


rule first_page:
    """What the report opens on: headline, sentences, the picture and the last decision."""
    input:
        verdict="results/verdict.zarr",
        decisions="results/decisions.csv",
        figure="figures/verdict.png",
    output:
        "results/first_page.html",
    log:
        "logs/first_page.log",
    script:
        "../scripts/first_page.py"


# Probability of each limit and its alarms, over the operations.
figure("health", "6 Decisions", of="", health="results/health.zarr")

# The trend of a source and its changes.
figure(
    "changepoint",
    "6 Decisions",
    label="change points",
    of="_{source}",
    truth=TRUTH,
    trend="results/trend/{source}.zarr",
)

# The remaining life of each limit, over the operations.
figure("remaining_life", "6 Decisions", of="", remaining="results/remaining.zarr")
