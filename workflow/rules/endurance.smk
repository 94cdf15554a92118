"""The endurance test: curves from files, inferred operation by operation.

Needs the model file, and curve files of the simulated endurance test or of the user's folder
(`endurance.curves`). Makes draws, intervals and flags of all operations, by the paper's networks
and by shipped networks of families, as Zarr stores and one tidy CSV a motion, and the figures of
the paper's Sec. 7.
"""


rule rig:
    """Write curve files of the simulated endurance test, a drive beyond the model, and their table."""
    input:
        code=code("rig"),
    output:
        directory("results/rig/curves"),
    log:
        "logs/rig.log",
    benchmark:
        "results/benchmarks/rig.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        motions=MOTIONS,
        rig=TEST,
    script:
        "../scripts/rig.py"


rule rig_truth:
    """Write the true state of the simulated endurance test, operation by operation."""
    input:
        code=code("rig_truth"),
    output:
        directory("results/rig/truth.zarr"),
    log:
        "logs/rig_truth.log",
    benchmark:
        "results/benchmarks/rig_truth.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        motions=MOTIONS,
        rig=TEST,
        grid=GRID,
        speeds=SPEEDS,
    script:
        "../scripts/rig_truth.py"


rule read_curves:
    """Read and check the files of some operations."""
    input:
        simulated=[] if OWN_CURVES else "results/rig/curves",
        code=code("read_curves"),
    output:
        directory("results/endurance/{motion}/curves_{chunk}.zarr"),
    log:
        "logs/read_curves/{motion}_{chunk}.log",
    benchmark:
        "results/benchmarks/read_curves_{motion}_{chunk}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        folder=OWN_CURVES,
        chosen=CHOSEN,
        source=source,
        format=config["endurance"]["format"],
        operations=operations,
        grid=GRID,
        speeds=SPEEDS,
        errors={name: config["sensor"][name] for name in ("noise_sd", "zero_sd", "onset_sd")},
    script:
        "../scripts/read_curves.py"


rule infer:
    """Infer some operations by the paper's network."""
    input:
        model="results/models/{motion}.safetensors",
        curves="results/endurance/{motion}/curves_{chunk}.zarr",
        code=code("infer"),
    output:
        directory("results/endurance/{motion}/inferred_{chunk}.zarr"),
    log:
        "logs/infer/{motion}_{chunk}.log",
    benchmark:
        "results/benchmarks/infer_{motion}_{chunk}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        draws=config["endurance"]["draws"],
        misfit_p_value=config["endurance"]["misfit_p_value"],
    script:
        "../scripts/infer.py"


rule infer_family:
    """Infer some operations by shipped networks of families."""
    input:
        curves="results/endurance/{motion}/curves_{chunk}.zarr",
        code=code("infer_family"),
    output:
        directory("results/endurance/{motion}/family_{chunk}.zarr"),
    log:
        "logs/infer_family/{motion}_{chunk}.log",
    benchmark:
        "results/benchmarks/infer_family_{motion}_{chunk}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        draws=config["endurance"]["draws"],
        misfit_p_value=config["endurance"]["misfit_p_value"],
        networks=shipped_networks,
    script:
        "../scripts/infer_family.py"


rule gather:
    """Collect all operations of one motion in stores and one table."""
    input:
        paper=every_chunk("results/endurance/{motion}/inferred_{chunk}.zarr"),
        family=every_chunk("results/endurance/{motion}/family_{chunk}.zarr") if EXACT else [],
        code=code("gather"),
    output:
        **{by: directory(store) for by, store in BY.items()},
        table="results/endurance/{motion}.csv",
    log:
        "logs/gather/{motion}.log",
    benchmark:
        "results/benchmarks/gather_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/gather.py"


rule endurance_predictive:
    """Predict records at a few stages of the life from their posteriors."""
    input:
        inferred="results/endurance/{motion}.zarr",
        code=code("endurance_predictive"),
    output:
        directory("results/endurance/{motion}_predictive.zarr"),
    log:
        "logs/endurance_predictive/{motion}.log",
    benchmark:
        "results/benchmarks/endurance_predictive_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        model=MODEL,
        prior=config["prior"],
        sensor=config["sensor"],
    script:
        "../scripts/endurance_predictive.py"


rule figures_endurance:
    """Figs. 9 and 10: posterior predictive check at stages of the life, and the parameters over it."""
    input:
        predictive="results/endurance/{motion}_predictive.zarr",
        paper="results/endurance/{motion}.zarr",
        family="results/endurance/{motion}_family.zarr",
        truth=TRUTH,
        code=code("figures_endurance"),
    output:
        predictive=page(
            "figures/endurance_predictive_{motion}.png",
            "5 Endurance test",
            "posterior predictive",
            "endurance_predictive",
        ),
        evolution=page(
            "figures/evolution_{motion}.png", "5 Endurance test", "evolution", "evolution"
        ),
    log:
        "logs/figures/endurance_{motion}.log",
    benchmark:
        "results/benchmarks/figures_endurance_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/figures_endurance.py"
