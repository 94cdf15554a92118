"""The records that a command names, read as those of one drive."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.files import Operation
from breaker.mechanism import MOTIONS, Size, Speed, check_quantity, speeds_of
from breaker.model import Facts, Model, configured_model, reference_model
from breaker.posterior import DriveRecords, read_drive
from breaker.records import read_curves
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

    With the default prior, and no network, the size of the drive is read from the records unless
    it is given, and so is the noise unless the configuration changes it. A prior of one's own is
    taken as it is, and a network has a prior, a sensor and motions of its own.

    Args:
        operations: By motion.
        config: The configuration.
        networks: By motion, if any.
        size: Factors on lengths and times of the reference drive, where they are known.
        loose: Whether each file may hold either motion or both.

    Raises:
        ValueError: If a size is given for a drive whose prior is not the default.
    """
    if size and networks:
        raise ValueError("--size is of drives with the default prior, not with that of --model")
    if networks and config["known"] and config["endurance"]["posterior"] != "corrected":
        raise ValueError(
            "networks know no facts; set endurance.posterior to corrected, or leave the facts out"
        )
    _check_known(config)
    found = (
        _by_networks(operations, config, networks)
        if networks
        else _by_prior(operations, config, size)
    )
    about = {
        "size": {"lengths": found.size.lengths, "times": found.size.times},
        "noise_sd": found.noise_sd,
        "words": [*found.said],
    }
    curves = _without_the_other(found.curves) if loose else dict(found.curves)
    facts = Facts.from_settings(config["known"], found.speeds)
    models = {motion: model.knowing(facts) for motion, model in found.models.items()}
    return Drive(models, curves, found.size, found.speeds, about)


def _check_known(config: Mapping) -> None:
    """Refuse facts about something unknown, before any file is read."""
    speeds = speeds_of(config["speeds"])
    for name in config["known"]:
        complaints = [check_quantity(name, motion, speeds) for motion in MOTIONS]
        if all(complaints):
            raise ValueError(f"known: {' '.join(complaints)}")


def _by_prior(
    operations: Mapping[str, Sequence[Operation]],
    config: Mapping,
    size: Sequence[float] | None,
) -> DriveRecords:
    """Read records for the prior of the configuration, the default one at any size."""
    defaults, scale = read(DEFAULTS), config["endurance"]["discrepancy"]
    own = any(config.get(key) != defaults.get(key) for key in ("prior", "size"))
    if own and size:
        raise ValueError(
            "--size is of drives with the default prior, and the configuration has another; leave "
            "it out"
        )
    if own:
        models = {motion: configured_model(config, motion) for motion in operations}
    else:
        models = {motion: reference_model(motion, scale) for motion in operations}
    noise_sd = config["sensor"]["noise_sd"]
    return read_drive(
        operations,
        config["endurance"]["format"],
        models,
        size=Size() if own else Size(*size) if size else None,
        noise_sd=noise_sd if own or noise_sd != defaults["sensor"]["noise_sd"] else None,
        speeds=_configured(config) if own else config["speeds"],
    )


def _configured(config: Mapping) -> dict[str, list[str]]:
    """The section ``speeds``, at the size of the drive whose prior stands in the configuration."""
    speeds = speeds_of(config["speeds"], Size(**config["size"]))
    return {each.name: each.points for each in speeds}


def _by_networks(
    operations: Mapping[str, Sequence[Operation]], config: Mapping, networks: Mapping
) -> DriveRecords:
    """Read records for networks, of whose motions, prior and sensor they are."""
    models = {motion: networks[motion].model for motion in operations if motion in networks}
    sensors = {motion: model.sensor for motion, model in models.items()}
    speeds = speeds_of(_configured(config))
    curves = {
        motion: read_curves(
            *(operations[motion], config["endurance"]["format"], sensor.times, motion),
            noise_sd=sensor.noise_sd,
            zero_sd=sensor.zero_sd,
            speeds=speeds,
        )
        for motion, sensor in sensors.items()
    }
    noise_sd = max(sensor.noise_sd for sensor in sensors.values())
    said = ("prior and sensor are those of the model files",)
    return DriveRecords(Size(), noise_sd, models, curves, speeds, said)


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
