"""How the operations of the endurance test are divided into jobs, and what each job takes.

A chunk holds the same numbers in every motion, so that appended operations run their own chunk and
no other. Trends go through the chunks one after the other.
"""

from functools import cache

from breaker.records import list_curves
from breaker.workflow import chunks_of

files_in = cache(list_curves)  # a folder is listed once, however many chunks there are


def curve_folder(wildcards):
    """Where the curve files of a motion are: the stand-in's own, or the user's."""
    return f"{OWN_CURVES or 'results/rig/curves'}/{wildcards.motion}"


def numbers(motion):
    """The numbers of the operations of a motion."""
    if OWN_CURVES is None:
        return range(1, config["rig"]["operations"] + 1)
    return [each.number for each in files_in(f"{OWN_CURVES}/{motion}")]


@cache
def chunks(motion=None):
    """The numbers of the operations of a motion, or of any motion, by chunk."""
    found = set().union(*map(numbers, [motion] if motion else MOTIONS))
    return chunks_of(found, config["endurance"]["operations_per_job"])


def operations(wildcards):
    """The numbers of the operations of a chunk: in the motion of the wildcards, or in any."""
    return chunks(wildcards.get("motion"))[wildcards.chunk]


def every_chunk(pattern):
    """A file of every chunk of the motion of the wildcards, or of any."""

    def files(wildcards):
        return [pattern.format(**wildcards, chunk=c) for c in chunks(wildcards.get("motion"))]

    return files


def curve_files(wildcards):
    """What the curves of a chunk are read from: the stand-in's folder, or the chunk's own files.

    A file each, so that appended operations run their own chunk again and no other.
    """
    folder = curve_folder(wildcards)
    if OWN_CURVES is None:
        return folder
    wanted = set(operations(wildcards))
    return [str(each.file) for each in files_in(folder) if each.number in wanted]


def corrected(motion):
    """What holds the operations of a chunk in a motion, if it is one of the source.

    A motion that has none of these operations gives its first ones, which are then left out.
    """

    def files(wildcards):
        if wildcards.get("source", "both") not in (motion, "both"):
            return []
        own = chunks(motion)
        chunk = wildcards.chunk if wildcards.chunk in own else next(iter(own))
        return [f"results/endurance/{motion}/corrected_{chunk}.zarr"]

    return files


CORRECTED = {motion: corrected(motion) for motion in MOTIONS}


def state_before(wildcards):
    """The state of a trend after the chunk before; the first one has none."""
    names = list(chunks())
    before = names[: names.index(wildcards.chunk)][-1:]
    return [f"results/trend/{wildcards.source}/state_{chunk}.zarr" for chunk in before]


def medians_of_source(wildcards):
    """What holds the posterior medians of single operations of a motion; of both there are none."""
    return [] if wildcards.source == "both" else [f"results/endurance/{wildcards.source}.zarr"]


def trust_of_sources(wildcards):
    """How far the model can be trusted, of each source, as known after all operations."""
    last = list(chunks())[-1]
    return [f"results/trend/{source}/trust_{last}.zarr" for source in SOURCES]
