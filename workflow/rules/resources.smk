"""Memory and time that jobs reserve with a scheduler, by rule, the only place of these numbers.

They are `max_rss` and `s` in results/benchmarks/ of runs of the defaults on two busy cores, as a
part of any size and parts that grow with a size. A job may take a quarter more, and a further
attempt once more of all. `python -m tests.workflow.benchmarks RUN` compares a run with them. Threads,
and graphics cards of trainings, stand with their rules.
"""

from math import ceil

MARGIN = 1.25
AROUND = 400  # MiB, of the two processes of Snakemake about a script that a scheduler starts
START = 1  # minute, for them to start

BANK, VALIDATION = config["bank"], config["validation"]
FAMILY_TRAINING = config["family_networks"]["training"]
# Sizes of the run, as multiples of the defaults.
SIZES = {
    "chunk": lambda: config["endurance"]["operations_per_job"] / 1000,
    "life": lambda: sum(map(len, chunks().values())) / 2000,
    "breakers": lambda: config["fleet"]["breakers_per_job"] / 30,
    "fleet": lambda: len(BREAKERS) / 1000,
    "rig": lambda: config["rig"]["operations"] / 2000,
    "shard": lambda: BANK["curves_per_shard"] / 65536,
    "bank": lambda: min(BANK["resident"], BANK["shards"] * BANK["curves_per_shard"]) / 262_144,
    "steps": lambda: max(t["steps"] * t["batch"] for t in config["training"].values()) / 3.84e6,
    "curves": lambda: VALIDATION["curves"] / 1000,
    "judged": lambda: VALIDATION["judged_curves"] / 1000,
    "draws": lambda: VALIDATION["curves"] * VALIDATION["draws"] / 500_000,
    "drives": lambda: config["family"]["drives"] / 250_000,
    "family_shard": lambda: config["family"]["drives"] / config["family"]["shards"] / 25_000,
    "family_steps": lambda: FAMILY_TRAINING["steps"] * FAMILY_TRAINING["batch"] / 8.192e6,
    "held_out": lambda: FAMILY_TRAINING["held_out_curves"] / 5000,
    "family_draws": lambda: FAMILY_TRAINING["held_out_curves"] * VALIDATION["draws"] / 2.5e6,
}
# Rule: MiB and s of any size; then by size the MiB and s that one of the defaults adds.
TAKEN = {
    "prior_predictive": (220, 5, {}),
    "bank_shard": (300, 5, {"shard": (50, 17)}),
    "train": (460, 30, {"bank": (410, 0), "steps": (0, 470)}),
    "validate": (485, 10, {"draws": (115, 5)}),
    "validate_reader": (480, 10, {"curves": (0, 24)}),
    "identifiability": (235, 9, {"curves": (50, 0)}),
    "quality": (115, 3, {"draws": (245, 0)}),
    "posterior_predictive": (220, 20, {"draws": (20, 0)}),
    "correct_validation": (245, 10, {"curves": (105, 18)}),
    "judge": (500, 5, {"judged": (0, 40)}),
    "rig": (165, 4, {"rig": (38, 10)}),
    "rig_truth": (245, 4, {"rig": (0, 7)}),
    "read_curves": (222, 3, {"chunk": (54, 12)}),
    "infer": (485, 10, {"chunk": (50, 12)}),
    "infer_family": (215, 8, {"chunk": (50, 40)}),
    "gather": (100, 3, {"life": (145, 0)}),
    "endurance_predictive": (220, 5, {"life": (65, 0)}),
    "life": (235, 6, {"life": (140, 13)}),
    "decide": (97, 4, {"life": (23, 0)}),
    "first_page": (85, 2, {}),
    "numbers": (115, 3, {"draws": (120, 0), "life": (60, 0)}),
    "fleet_chunk": (242, 5, {"breakers": (0, 150)}),
    "fleet": (200, 8, {"fleet": (50, 2)}),
    "family_shard": (280, 10, {"family_shard": (160, 145)}),
    "family_held_out": (220, 5, {"held_out": (80, 24)}),
    "family_train": (480, 30, {"drives": (2220, 0), "family_steps": (0, 920)}),
    "validate_family": (245, 6, {"family_draws": (780, 32)}),
    "family_quality": (115, 4, {"family_draws": (760, 10)}),
    "figure_prior_predictive": (185, 5, {}),
    "figure_loss": (155, 8, {}),
    "figure_sbc": (185, 9, {"draws": (60, 0)}),
    "figure_sbc_reader": (185, 12, {"draws": (70, 0)}),
    "figure_contraction": (185, 7, {"draws": (145, 0)}),
    "figure_recovery": (190, 11, {"draws": (80, 0)}),
    "figure_pairs": (250, 27, {"draws": (40, 0)}),
    "figure_posterior_predictive": (165, 7, {}),
    "figure_endurance_predictive": (180, 10, {}),
    "figure_exactness": (200, 10, {"curves": (100, 0)}),
    "figure_identifiability": (200, 5, {"draws": (140, 0)}),
    "figure_verdict": (145, 5, {}),
    "figure_health": (160, 5, {}),
    "figure_service_cost": (160, 5, {}),
    "figure_changepoint": (180, 4, {}),
    "figure_remaining_life": (170, 6, {}),
    "figure_evolution": (185, 9, {"life": (90, 0)}),
    "figure_changes": (185, 9, {}),
    "figure_sbc_family": (185, 7, {"family_draws": (230, 0)}),
    "figure_contraction_family": (180, 8, {"family_draws": (655, 0)}),
    "figure_recovery_family": (190, 6, {"family_draws": (310, 0)}),
    "figure_pairs_family": (230, 12, {"family_draws": (120, 0)}),
}


def taken(rule):
    """Memory, MiB, and time, s, that a job of the configured sizes takes."""
    memory, seconds, parts = TAKEN[rule]
    grown = [(SIZES[size](), *part) for size, part in parts.items()]
    return (
        memory + sum(size * more for size, more, _ in grown),
        seconds + sum(size * more for size, _, more in grown),
    )


def resources_of(rule):
    """What a job reserves with a scheduler, as functions that Snakemake asks."""

    def mem_mb(wildcards, attempt):
        return ceil(attempt * (AROUND + MARGIN * taken(rule)[0]))

    def runtime(wildcards, attempt):
        return attempt * (START + ceil(MARGIN * taken(rule)[1] / 60))

    return {"mem_mb": mem_mb, "runtime": runtime} if rule in TAKEN else {}
