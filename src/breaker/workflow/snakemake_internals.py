"""All that the workflow uses of Snakemake and Snakemake does not document, in one place.

A release may rename any of it. Python sets an attribute that nobody reads without a word, so the
Snakefile asks ``lacking`` first, and stops with what is gone and what depends on it.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from breaker.workflow.dependencies import modules_of

_OF_WORKFLOW = {
    "configfiles": "messages name the file of a wrong key",
    "overwrite_configfiles": "messages name the file of a wrong key",
    "current_basedir": "scripts and defaults are found from any --directory",
    "deployment_settings": "packages are looked for unless jobs have environments of their own",
    "get_rule": "rules that are used anew find their scripts",
    "is_main_process": "the configuration is checked once, not in every job",
    "modifier": "a module has rules and files of its own",
    "resource_settings": "resources of the command line win",
    "sourcecache": "scripts of a repository are found",
}
_OF_MODIFIER = {
    "path_modifier": "checkpoints of a module are below its prefix",
    "rule_proxies": "a module completes its own rules alone",
}
_OF_RULE = {
    "basedir": "the modules that a script uses are inputs",
    "benchmark": "rules have a benchmark",
    "benchmark_modifier": "rules have a benchmark",
    "input_modifier": "the modules that a script uses are inputs",
    "log": "a benchmark is named as the log",
    "output_modifier": "inputs and benchmarks are found as outputs are",
    "params": "the modules that a script uses are inputs",
    "resources": "rules have memory and time",
    "script": "rules with a script are completed",
    "set_input": "the modules that a script uses are inputs",
}


def lacking(workflow: Any) -> str:
    """Return what this release of Snakemake lacks and the remedy, or nothing where all is there.

    Args:
        workflow: The object ``workflow`` of a Snakefile; with rules, one of them is looked at too.

    Example:
        >>> lacking(object()).splitlines()[1]
        '  workflow.configfiles, by which messages name the file of a wrong key'
    """
    used = [(workflow, "workflow", _OF_WORKFLOW)]
    used += [(m, "modifier", _OF_MODIFIER) for m in [getattr(workflow, "modifier", None)] if m]
    used += [(rule, "rule", _OF_RULE) for rule in list(_own_rules(workflow).values())[:1]]
    gone = [
        f"  {kind}.{name}, by which {use}"
        for thing, kind, names in used
        for name, use in names.items()
        if not hasattr(thing, name)
    ]
    if not gone:
        return ""
    return "\n".join(
        [
            "this release of Snakemake lacks what the workflow uses:",
            *gone,
            "Install the one in envs/requirements.lock (`make environment`), or adapt "
            "breaker.workflow.snakemake_internals.",
        ]
    )


def configuration_files(workflow: Any) -> list[Path | str]:
    """Return the files of the configuration: overlays, the last first, then the defaults."""
    overlays = list(workflow.overwrite_configfiles)
    return [*reversed(overlays), *reversed(workflow.configfiles[len(overlays) :])]


def is_first_process(workflow: Any) -> bool:
    """Return whether this is the process of the command, not that of a job."""
    return workflow.is_main_process


def deploys(workflow: Any) -> bool:
    """Return whether jobs have environments of their own."""
    return bool(workflow.deployment_settings.deployment_method)


def folder_of(workflow: Any) -> Path:
    """Return the folder of the Snakefile that is being read; no folder if it is in a repository."""
    return Path(str(workflow.current_basedir))


def placing(workflow: Any) -> Callable[[str], str]:
    """Return what puts a path where the module that is being read has its files.

    Snakemake does so with inputs, outputs and logs, but not with paths that code or scripts open.
    """
    return workflow.modifier.path_modifier.replace_prefix


def _own_rules(workflow: Any) -> dict[str, Any]:
    """Rules of the workflow, or of the module, that is being read, by the names they have there."""
    proxies = getattr(getattr(workflow, "modifier", None), "rule_proxies", None)
    return {name: proxy.rule for name, proxy in getattr(proxies, "_rules", {}).items()}


def make_again(workflow: Any, file: str) -> None:
    """Let the job of a file run, whatever Snakemake knows of it."""
    workflow.dag.forcefiles.add(file)


def keep_scripts(workflow: Any, rules: Mapping[str, str]) -> None:
    """Let scripts of rules that are used anew stay where those of the original rules are.

    Args:
        workflow: The object ``workflow`` of a Snakefile.
        rules: Name of each rule, and of the one that it was made of.
    """
    for new, rule in rules.items():
        workflow.get_rule(new).basedir = workflow.get_rule(rule).basedir


def complete_rules(workflow: Any, resources_of: Callable[[str], Mapping[str, Any]]) -> None:
    """Give rules with a script what all of them have in common, once all are stated.

    That is resources, a benchmark named as the log, and the modules of the package that the script
    uses: they become inputs, since Snakemake sees a change of the script alone.

    Args:
        workflow: The object ``workflow`` of a Snakefile.
        resources_of: Resources by name, of a rule by name; those of the command line win.
    """
    from snakemake.io import local  # code is no part of a storage of results

    for name, each in _own_rules(workflow).items():
        if each.script and "code" not in each.input.keys():  # noqa: SIM118
            each.resources.update(resources_of(name))
            each.resources.update(workflow.resource_settings.overwrite_resources.get(each.name, {}))
            if each.benchmark is None:
                each.benchmark_modifier = each.output_modifier
                place = Path(each.log[0].rpartition("logs/")[2]).with_suffix(".tsv").parts
                each.benchmark = "results/benchmarks/" + "_".join(place)
            each.input_modifier = each.output_modifier  # has none yet if the rule states no input
            script = workflow.sourcecache.get_path(each.basedir.join(each.script))
            each.set_input(code=list(map(local, modules_of(script, each.params.get("within")))))
