"""The workflow in the project's folder, with its settings; profiles/default has its options."""


configfile: "config/advanced.yaml"
configfile: "config/config.yaml"


include: "workflow/Snakefile"


# The setting of the paper as printed, in a folder of its own.
module printed:
    snakefile:
        "workflow/Snakefile"
    config:
        merge(config, read("config/paper.yaml"))
    prefix:
        "paper"


use rule * from printed exclude reproduction as paper_*


use rule reproduction from printed as paper


rule everything:
    """What `all` makes, for a command without a target: a file that is included has no default."""
    default_target: True
    input:
        rules.all.input,
