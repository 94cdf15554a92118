"""The records that a command names, read as those of one drive."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.files import Operation
from breaker.mechanism import MOTIONS, Size, Speed, check_quantity, speeds_of
from breaker.model import Facts, Model, configured_model, reference_model
from breaker.posterior import read_drive
from breaker.shipped import DEFAULTS
from breaker.workflow import read

__all__ = ["Drive", "networks_of", "read_records"]

_LACKS = "which is no "  # in the reason of a record without the motion, which follows


@dataclass(frozen=True)
class Drive:
    """The records of a drive, and what they are to be inferred with.

    Attributes:
        models: Joint model of each motion.
        curves: Records of each motion on its model's grid: see ``records.read_curves``.
        size: Its size beside the reference drive.
        speeds: How its speeds are defined.
        about: What is known of the drive as a whole, as plain values.
    """

    models: Mapping[str, Model]
    curves: Mapping[str, xr.Dataset]
    size: Size
    speeds: tuple[Speed, ...]
    about: dict


def networks_of(files: Sequence[str], config: Mapping) -> dict:
    """Return trained networks by motion, at the scale of the configuration.

    Raises:
        ValueError: If two are of the same motion.
    """
    if not files:
        return {}
    from breaker.posterior import Posterior  # loads torch

    networks = {}
    for file in files:
        network = Posterior.load(file).at(config["endurance"]["discrepancy"])
        if network.motion in networks:
            raise ValueError(f"{file} is a second model of {network.motion}; leave one of them out")
        networks[network.motion] = network
    return networks


def read_records(
    operations: Mapping[str, Sequence[Operation]],
    config: Mapping,
    networks: Mapping,
    *,
    size: Sequence[float] | None = None,
    loose: bool = False,
) -> Drive:
    """Read the records of a drive.

    With the default prior the size of the drive is read from the records unless it is given, and
    so is the noise unless the configuration changes it. A prior of one's own is taken as it is.
    Networks have a prior and motions of their own.

    Args:
        operations: By motion.
        config: The configuration.
        networks: By motion, if any.
        size: Factors on lengths and times of the reference drive, where they are known.
        loose: Whether each file may hold either motion or both.

    Raises:
        ValueError: If a size is given for a drive whose prior is not the default.
    """
    _check_known(config)
    models, noise_sd, own = _of_size_one(operations, config, networks)
    if size and own:
        raise ValueError(
            "--size is of drives with the default prior, and that of the configuration or of "
            "--model is another; leave it out"
        )
    if networks and config["known"] and config["endurance"]["posterior"] != "corrected":
        raise ValueError(
            "networks know no facts; set endurance.posterior to corrected, or leave the facts out"
        )
    found = read_drive(
        {motion: operations[motion] for motion in models},
        config["endurance"]["format"],
        models,
        size=Size() if own else Size(*size) if size else None,
        noise_sd=noise_sd,
        speeds=_configured(config) if own else config["speeds"],
    )
    named = Size(**config["size"]) if own else found.size
    about = {
        "size": {"lengths": named.lengths, "times": named.times},
        "noise_sd": found.noise_sd,
        "words": [*found.said, *_given(own, size, networks)],
    }
    curves = _without_the_other(found.curves) if loose else dict(found.curves)
    facts = Facts.from_settings(config["known"], found.speeds)
    models = {motion: model.knowing(facts) for motion, model in found.models.items()}
    return Drive(models, curves, found.size, found.speeds, about)


def _given(own: bool, size: Sequence[float] | None, networks: Mapping) -> list[str]:
    """What of the drive was not read from its records, in words."""
    if own:
        return [
            f"prior and noise are those of {'the model file' if networks else 'the configuration'}"
        ]
    if size:
        return [
            "size given: lengths {:g} and times {:g} times those of the reference drive".format(
                *size
            )
        ]
    return []


def _check_known(config: Mapping) -> None:
    """Refuse facts about something unknown, before any file is read."""
    speeds = speeds_of(config["speeds"])
    for name in config["known"]:
        complaints = [check_quantity(name, motion, speeds) for motion in MOTIONS]
        if all(complaints):
            raise ValueError(f"known: {' '.join(complaints)}")


def _of_size_one(
    operations: Mapping[str, Sequence[Operation]], config: Mapping, networks: Mapping
) -> tuple[dict[str, Model], float | None, bool]:
    """Return models of the size 1, the noise where it is not to be read, and whether the prior is
    not the default one, so that no size is to be read either.
    """
    defaults, scale = read(DEFAULTS), config["endurance"]["discrepancy"]
    noise_sd = config["sensor"]["noise_sd"]
    changed = noise_sd if noise_sd != defaults["sensor"]["noise_sd"] else None
    if networks:
        models = {motion: networks[motion].model for motion in operations if motion in networks}
        own = any(each.settings["prior"] != defaults["prior"] for each in networks.values())
        sensors = [model.sensor for model in models.values()]
        return models, max(each.noise_sd for each in sensors) if own else changed, own
    if any(config[key] != defaults[key] for key in ("prior", "size")):
        return {motion: configured_model(config, motion) for motion in operations}, noise_sd, True
    return {motion: reference_model(motion, scale) for motion in operations}, changed, False


def _configured(config: Mapping) -> dict[str, list[str]]:
    """The section ``speeds``, at the size of the drive whose prior stands in the configuration."""
    speeds = speeds_of(config["speeds"], Size(**config["size"]))
    return {each.name: each.points for each in speeds}


def _without_the_other(curves: Mapping[str, xr.Dataset]) -> dict[str, xr.Dataset]:
    """Leave out of each motion the files that hold the other one alone.

    A file that cannot be used for the same reason in both motions is left in the first.
    """
    if len(curves) < 2:
        return dict(curves)
    first, second = curves.values()
    lacks = {m: np.char.find(each.reason.values, f"{_LACKS}{m}") >= 0 for m, each in curves.items()}
    one, other = lacks.values()
    same = ~first.accepted.values & (first.reason.values == second.reason.values)
    kept = first.isel(operation=~one | other), second.isel(operation=~(other | same))
    found = dict(zip(curves, kept, strict=True))
    return {motion: each for motion, each in found.items() if each.sizes["operation"]}
