"""Change points and remaining life judged on simulated lives, outside of `all`.

Needs the model files of both motions. Goes through the lives in jobs of a few, each life with
generators of its own; an interrupted evaluation goes on with the jobs that are missing.
"""


rule follow_lives:
    """Simulate some lives, infer their records and follow them."""
    input:
        models=expand("results/models/{motion}.safetensors", motion=["closing", "opening"]),
    output:
        directory("results/lives/seed{seed}/lives_{chunk}.zarr"),
    log:
        "logs/follow_lives/seed{seed}_{chunk}.log",
    params:
        lives={
            key: config["lives"][key]
            for key in config["lives"]
            if key not in ("seed", "calibration_seed")
        },
        calibration_seed=config["lives"]["calibration_seed"],
        wear_model={
            key: config["wear_model"][key]
            for key in config["wear_model"]
            if key not in ("agreement_p_value", "notice", "toward")
        },
    script:
        "../scripts/follow_lives.py"


rule calibrate_lives:
    """The widening of trends with which intervals of the remaining life hold what they promise."""
    input:
        lives=lives_of_seed,
    output:
        "results/lives/widening.csv",
    log:
        "logs/calibrate_lives.log",
    script:
        "../scripts/calibrate_lives.py"


rule score_lives:
    """Delays, false alarms, coverage and accuracy over all lives, beside other detectors."""
    input:
        lives=lives_of_seed,
    output:
        scores=directory("results/lives/scores_seed{seed}.zarr"),
        table=page(
            "results/lives/scores_seed{seed}.csv",
            "7 Simulated lives",
            "table of scores",
            "prognostics_table",
        ),
        detectors="results/lives/detectors_seed{seed}.csv",
    log:
        "logs/score_lives/seed{seed}.log",
    params:
        toward=config["wear_model"]["toward"],
        settle=config["wear_model"]["settle"],
    script:
        "../scripts/score_lives.py"


# How early changes are found, and how good the remaining life is.
figure(
    "prognostics",
    "7 Simulated lives",
    of="",
    scores=f"results/lives/scores_seed{config['lives']['seed']}.zarr",
)


# What else could notice a change, and how early at how many false alarms.
figure(
    "detectors",
    "7 Simulated lives",
    of="",
    params={"lives": config["lives"]["lives"], "alarm_level": config["wear_model"]["alarm_level"]},
    detectors=f"results/lives/detectors_seed{config['lives']['seed']}.csv",
)
