"""All settings with type, default, description and bounds, in a tree as in the files.

``make defaults`` writes the files in ``config``, the JSON schema and the page of settings from
this tree, and ``problems`` compares a configuration with it.
"""

import json
import re
from collections.abc import Callable, Mapping
from copy import deepcopy
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    RootModel,
    ValidationError,
    create_model,
)

from breaker.configuration.loading import WIDEST
from breaker.model.parameters import NAMES
from breaker.model.quantities import speeds_of

ADVANCED = ("network", "training", "by_motion", "bank", "family", "validation", "simulated_test")
"""Sections in ``config/advanced.yaml``, which few users change."""


class Section(BaseModel):
    """A section without unknown keys and without conversions, such as of a text to a number."""

    model_config = ConfigDict(
        strict=True, extra="forbid", allow_inf_nan=False, defer_build=True, validate_default=False
    )


def _section(text: str, **parts: tuple[Any, Any] | type[Section]) -> type[Section]:
    """Return a section with a description, settings (type and default) and subsections."""
    fields = {name: (part, ...) if isinstance(part, type) else part for name, part in parts.items()}
    return create_model(text, __base__=Section, __doc__=text, **fields)


def _f(
    kind: Any, default: Any, text: str, low: Any = None, high: Any = None, **more: Any
) -> tuple[Any, Any]:
    """Return type and default of a setting, with description, smallest and largest value."""
    return kind, Field(default, description=text, ge=low, le=high, **more)


def _text(most: int = 1000, **more: Any) -> Any:
    return Annotated[str, Field(min_length=1, max_length=most, **more)]


def _form(most: int, pattern: str, words: str, number: Any = None) -> Any:
    """Return a text type for a pattern, or also a number; messages state ``words``."""
    text, fits = _text(most, json_schema_extra={"pattern": pattern}), re.compile(pattern).fullmatch
    kind = text if number is None else number | text
    return _where(kind, lambda value: not isinstance(value, str) or fits(value), f"must be {words}")


def _number(kind: type, low: float | None = None, high: float | None = None, **more: Any) -> Any:
    return Annotated[kind, Field(ge=low, le=high, **more)]


def _list(entry: Any, least: int, most: int) -> Any:
    return Annotated[list[entry], Field(min_length=least, max_length=most)]


def _where(kind: Any, holds: Callable, text: str, when: type = AfterValidator) -> Any:
    def check(value: Any) -> Any:
        if not holds(value):
            raise ValueError(text)
        return value

    return Annotated[kind, when(check)]


Motion = Literal["closing", "opening"]
_FUNCTION = r"[A-Za-z_][\w.]*:[A-Za-z_]\w*"
Function = _form(200, f"^{_FUNCTION}$", "module:function")
Summary = _form(200, f"^(time_series|{_FUNCTION})$", "module:function or time_series")
Column = _text(200) | _number(int, 1, 1000)
Trigger = _text(200) | _number(int, 0, 1000)
Amount = _number(float, -1e6, 1e6)
Points = _list(_text(100), 2, 2)
_SPEED = r"^(closing|opening)_speed(_[a-z0-9_]+)?$"
SpeedName = _form(100, _SPEED, "closing_speed or opening_speed, or one of these with _ and a name")
Speeds = Annotated[dict[SpeedName, Points | None], AfterValidator(speeds_of)]
_QUANTITY = r"^[+-]?[0-9]{1,6}(\.[0-9]{1,6})?( \S+| ?%)$"
Quantity = _form(40, _QUANTITY, "a number, or one with its unit, such as 14.1 mm or +15 %", Amount)
_IN_TYPE = "must be the least and largest value, such as [13.5 mm, 15 mm] or [13.5 mm, null]"
Range = _where(
    _list(Quantity | None, 2, 2), lambda e: isinstance(e, list), _IN_TYPE, BeforeValidator
)
_IN_LIMIT = "must be quantities with values, such as {travel_time: 12 ms}"
Bounds = _where(dict[str, Quantity], lambda e: isinstance(e, dict), _IN_LIMIT, BeforeValidator)
_TOLERANCE = r"^(±|\+/?-)? ?[0-9]{1,6}(\.[0-9]{1,6})?( \S+| ?%)?$"
_POSITIVE = _number(float, high=1e6, gt=0)
Tolerance = _form(20, _TOLERANCE, "a number, or a text such as 3 % or ±0.4 mm", _POSITIVE)
Text = _text()
Unit = Literal["mm", "cm", "m", "um", "inch", "deg", "rad", "V", "counts", "%"]
Stroke = _list(_number(float, high=1000, gt=0), 2, 2)
Sizes = _list(_number(int, 1, 10_000), 1, 16)
Hidden = _list(_number(int, 1, 512), 1, 4)
Optimiser = Literal["muon", "muon_edges"]
Posterior = Literal["amortised", "corrected"]
Motions = _where(
    _list(Motion, 1, 2), lambda some: len({*some}) == len(some), "must not have a motion twice"
)
_INTERVAL = r"^(every operation|([0-9]+\.)?[0-9]*[1-9][0-9]* (operation|year)s?)$"
Interval = _form(40, _INTERVAL, "every operation, or a text such as 100 operations or 1 year")
Events = dict[str, _list(Literal[("all", "transducer", *NAMES)], 0, 9)]

LogNormal = _section(
    "A log-normal distribution.",
    median=_f(float, 1.0, "Median before the conditioning, in the parameter's unit.", 1e-4, 1000),
    log_sd=_f(float, 0.2, "Standard deviation of the natural logarithm.", 1e-3, WIDEST),
)


def _prior(median: float, log_sd: float, text: str) -> Any:
    return LogNormal, Field({"median": median, "log_sd": log_sd}, description=text)


Network = _section(
    "Summary and inference network of both motions.",
    summary=_section(
        "Network from a record to features: convolutions, GRU, skip GRU and a linear highway.",
        kind=_f(Summary, "time_series", "time_series, or module:function of your own network."),
        features=_f(int, 64, "Features passed to the inference network.", 1, 1024),
        components=_f(int, 24, "Linear components of the highway.", 1, 1024),
        channels=_f(Sizes, [16], "Output channels of the convolutions, one entry a layer."),
        kernels=_f(Sizes, [16], "Kernels of the convolutions, samples."),
        strides=_f(Sizes, [16], "Strides of the convolutions, samples."),
        gru_width=_f(int, 16, "Width of the GRU.", 1, 1024),
        skip=_f(int, 3, "Steps after the convolutions that the skip GRU spans.", 1, 10_000),
        skip_width=_f(int, 8, "Width of the skip GRU.", 1, 1024),
        width=_f(int, 192, "Width of the residual network that joins the parts.", 1, 1024),
        blocks=_f(int, 2, "Blocks of this residual network.", 1, 8),
    ),
    inference=_section(
        "Network from features to the posterior; only the section of the chosen kind is used.",
        kind=_f(Literal["coupling_flow", "flow_matching"], "coupling_flow", "Kind of network."),
        flow_matching=_section(
            "Continuous normalising flow, trained by flow matching.",
            width=_f(int, 128, "Width of the residual blocks of the velocity field.", 1, 1024),
            blocks=_f(int, 3, "Residual blocks of the velocity field.", 1, 8),
        ),
        coupling_flow=_section(
            "Coupling flow of rational-quadratic splines.",
            transforms=_f(int, 4, "Couplings.", 1, 16),
            bins=_f(int, 8, "Bins of a spline.", 2, 32),
            hidden=_f(Hidden, [96, 96], "Widths of the hidden layers of each coupling's network."),
        ),
    ),
)

Training = _section(
    "Training of the networks of both motions.",
    steps=_f(int, 2300, "Optimiser steps.", 1, 10_000_000),
    batch=_f(int, 1024, "Curves in a step.", 1, 50_000),
    optimiser=_f(Optimiser, "muon_edges", "muon: Muon for hidden matrices; muon_edges: for all."),
    learning_rate=_f(float, 0.003, "Highest learning rate.", high=1, gt=0),
    evaluate_every=_f(int, 100, "Steps between two evaluations.", 1, 10_000_000),
    checkpoint_every=_f(int, 1000, "Steps between two checkpoints.", 1, 10_000_000),
    validation_curves=_f(int, 1024, "Curves that choose the best weights.", 1, 1_000_000),
    held_out_curves=_f(int, 200, "Curves for the final log density.", 1, 1_000_000),
    threads=_f(int, 1, "CPU threads of each training.", 1, 1024),
    device=_f(Literal["auto", "cpu", "cuda"], "auto", "Device; auto is CUDA if available."),
)

OfMotion = _section("Differences for one motion.", network=Network, training=Training)

Limit = _section(
    "A limit: a name, `upper` or `lower`, usually a motion; or quantity, reference, tolerance.",
    name=(_form(100, r"^[^;\x00-\x1f\x7f-\x9f]+$", "a text on one line without ;"), ""),
    motion=(Motion, "closing"),
    of=(Literal["model", "record", "change"], "model"),
    upper=(Bounds, {}),
    lower=(Bounds, {}),
    quantity=(_text(100), ""),
    reference=(Quantity, 0.0),
    tolerance=(Tolerance, 1.0),
)


_LIMITS = [
    {"name": "slow_closing", "motion": "closing", "of": "record", "upper": {"travel_time": 9.5}},
    {"name": "slow_opening", "motion": "opening", "of": "record", "upper": {"travel_time": 12.2}},
    {"name": "short_stroke", "motion": "closing", "of": "record", "lower": {"stroke": 14.1}},
    {"name": "stiff_drive", "of": "change", "upper": {"gamma_a": "+15 %"}},
    {"name": "tired_closing", "of": "change", "lower": {"f": "-6 %"}},
]

Settings = _section(
    "The settings of the workflow and of the command `breaker`.",
    seed=_f(int, 1, "Seed of all random numbers except in the validation.", 0, 2**32 - 1),
    motions=_f(Motions, ["closing", "opening"], "Motions to work on: closing, opening or both."),
    model=_section(
        "Your own functions that replace the simulator or the prior.",
        simulator=_f(Function | None, None, "module:function of a simulator; null: paper's drive."),
        prior=_f(
            Function | None, None, "module:function; the family still uses the section prior."
        ),
    ),
    prior=_section(
        "Log-normal prior, cut to f > k_a L (the contact closes). The medians are before the cut.",
        mu=_prior(2.0, 0.2, "Mass ratio of drive to contact, M_a / M_b."),
        k_a=_prior(0.045, 0.15, "1/ms^2, opening spring on the main shaft."),
        k_b=_prior(0.04, 0.2, "1/ms^2, contact spring in the pushrod."),
        gamma_a=_prior(0.3, 0.2, "1/ms, damping of the drive."),
        gamma_b=_prior(0.12, 0.4, "1/ms, damping of the contact spring."),
        f=_prior(0.75, 0.1, "mm/ms^2, closing force per drive mass."),
        L=_prior(10.0, 0.05, "mm, contact gap."),
    ),
    sensor=_section(
        "Travel sensor: its time grid around the nominal start of motion, and its errors.",
        start=_f(float, -2.0, "ms, first sample, before the nominal start.", -1000, lt=0),
        stop=_f(float, 58.0, "ms, last sample.", 1, 10_000),
        samples=_f(int, 151, "Number of samples of a record, both ends included.", 4, 2000),
        noise_sd=_f(float, 0.1, "mm, standard deviation of the noise of one sample.", 1e-4, 10),
        onset_sd=_f(float, 0.3, "ms, sd of the start of motion; 0 means no onset.", 0, 20),
        zero_sd=_f(float, 0.1, "mm, sd of the offset of a record; 0 means none.", 0, 20),
    ),
    size=_section(
        "Size of the drive relative to the default drive; by default it is read from records.",
        lengths=_f(float, 1.0, "Factor on lengths: 10 for a stroke of about 150 mm.", 0.01, 100),
        times=_f(float, 1.0, "Factor on times: 4 if a motion takes four times as long.", 0.01, 100),
    ),
    endurance=_section(
        "Measured curves and their inference.",
        curves=_f(Text | None, None, "Folder of the curve files; null is the simulated test."),
        breaker=_f(Text | None, None, "Breaker to use, if operations.csv has several; null: all."),
        phase=_f(Text | None, None, "Phase to use, if there are several."),
        events=_f(Events, {}, "More events and their renewed parameters: {oil: [gamma_a]}."),
        operations_per_job=_f(int, 1000, "Operations read and inferred by one job.", 1, 100_000),
        draws=_f(int, 500, "Posterior draws of each operation.", 10, 25_000),
        misfit_p_value=_f(float, 1e-3, "p-value below which a record is flagged.", gt=0, lt=1),
        format=_section(
            "Layout of a curve file. `breaker inspect FILE` proposes it.",
            encoding=_f(str, "utf-8", "Encoding of the text.", min_length=1, max_length=50),
            delimiter=_f(Literal[",", ";", "\t", "|", " "], ",", "Character between columns."),
            decimal=_f(Literal[".", ","], ".", "Decimal sign of numbers."),
            time_column=_f(Column | None, "time", "Name or number of the time column; or null."),
            time_unit=_f(Literal["s", "ms", "us"], "s", "Unit of the time."),
            rate=_f(float | None, None, "kHz, sampling rate, without a time column.", 0.95, 1000),
            travel_column=_f(Column, "travel", "Name or number of the travel column."),
            travel_unit=_f(Unit, "mm", "Unit of the travel; all but lengths need ratio."),
            ratio=_f(float | None, None, "mm per travel_unit, such as of a lever.", 1e-6, 1e6),
            zero=_f(Amount | Literal["rest"], 0.0, "Reading when open; rest: from each record."),
            sign=_f(Literal[1, -1], 1, "1 if the reading grows towards closed, -1 if it falls."),
            quantum=_f(float | None, None, "mm, step of the reading; null finds it.", 0, 10),
            stroke=_f(Stroke | None, None, "mm, least and largest stroke; null: of any breaker."),
            contact_column=_f(Column | None, None, "Name or number of the main contact's column."),
            current_column=_f(Column | None, None, "Column of the test current of the contact."),
            timing_sd=_f(float, 0.1, "ms, sd of the times of touch and separation.", 0.01, 10),
            trigger_column=_f(Trigger | None, None, "Column of trigger or coil; 0: at time 0."),
            missing=_f(float, 0.5, "Largest share of missing samples.", 0, 0.8),
        ),
    ),
    network=Network,
    training=Training,
    by_motion=_f(
        dict[Motion, OfMotion],
        {"opening": {"training": {"steps": 2850}}},
        "Differences for one motion: the narrower posterior of an opening needs more steps.",
    ),
    bank=_section(
        "Training bank of each motion: curves without noise, one Zarr store and one job a shard.",
        shards=_f(int, 4, "Zarr stores; raising it simulates only new ones.", 1, 1000),
        curves_per_shard=_f(int, 65_536, "Curves in each shard.", 1, 10_000_000),
        online=_f(bool, False, "Whether to simulate each batch; the bank then only validates."),
    ),
    family=_section(
        "Family of drives with effects that the model lacks, and the networks trained on it.",
        name=_f(Text, "medium_voltage", "medium_voltage, any, or your own YAML file."),
        drives=_f(int, 200_000, "Drives in the bank, new and worn, in both motions.", 1, 10**7),
        shards=_f(int, 10, "Zarr stores of the bank, one job each.", 1, 1000),
        network=_section(
            "Networks of a family: a residual network, and a mixture of Gaussians for each output.",
            width=_f(int, 256, "Width of the residual network.", 1, 4096),
            blocks=_f(int, 3, "Blocks of the residual network.", 0, 100),
            features=_f(int, 64, "Features passed to the mixtures.", 1, 4096),
            components=_f(int, 6, "Gaussians in the mixture of an output.", 1, 100),
            head=_f(int, 48, "Width of the network of an output.", 1, 4096),
        ),
        training=_section(
            "Training of the networks of a family, with threads and device of `training`.",
            steps=_f(int, 14_000, "Optimiser steps.", 1, 10_000_000),
            batch=_f(int, 1024, "Drives in a step.", 1, 50_000),
            evaluate_every=_f(int, 500, "Steps between two evaluations.", 1, 10_000_000),
            checkpoint_every=_f(int, 1000, "Steps between two checkpoints.", 1, 10_000_000),
            validation_curves=_f(int, 2000, "Drives that choose the best weights.", 1, 1_000_000),
            held_out_curves=_f(int, 5000, "Drives for checks and membership tests.", 1, 1_000_000),
            workers=_f(int, 0, "Processes for batches; no effect on weights.", 0, 1024),
        ),
    ),
    validation=_section(
        "Checks of the posterior on curves that are not used in a training.",
        curves=_f(int, 1000, "Validation curves of a motion.", 10, 100_000),
        draws=_f(int, 500, "Posterior draws of each curve.", 10, 100_000),
        seed=_f(int, 11, "Seed; a second validation uses the next one.", 0, 2**32 - 2),
        posterior=_f(Posterior, "amortised", "In figures: amortised (network) or corrected."),
        judged_curves=_f(int, 1000, "Curves compared with the exact posterior.", 10, 100_000),
        prior_curves=_f(int, 2000, "Curves of the prior predictive figure.", 20, 50_000),
        limit_curves=_f(int, 1000, "Prior draws of the exact limit of contraction.", 10, 100_000),
        correction_rounds=_f(int, 20, "Largest number of rounds of the correction.", 1, 1000),
    ),
    simulated_test=_section(
        "Simulated endurance test: CSV files of a wearing drive that the model does not fit.",
        operations=_f(int, 2000, "Close-open operations until the end of life.", 2, 100_000),
    ),
    speeds=_f(
        Speeds,
        {"closing_speed": None, "opening_speed": None},
        "Speeds between two points; null: over 6 mm at contact touch, for a stroke of 12.5 mm.",
    ),
    limits=_f(_list(Limit, 1, 100), _LIMITS, "Limits; your limits replace all of these."),
    types=_f(Text | None, None, "YAML file of types of breaker (docs/how-to/limits-and-types.md)."),
    planning=_section(
        "Planning of services (docs/understand/planning-a-service.md).",
        operations=_f(float, 500, "Operations ahead.", 0, 1e9),
        years=_f(float, 2.0, "Years ahead, where dates are known.", 0, 100),
        service_cost=_f(float, 1.0, "Cost of a planned service.", high=1e12, gt=0),
        failure_cost=_f(float, 20.0, "Cost of a failure; more than a service.", 0, 1e12),
        inspection=_f(Interval, "every operation", "Or an interval, such as 1 year."),
        sudden_failures=_f(float, 0.0015, "Sudden failures of a drive per year; 0: none.", 0, 10),
    ),
    trend=_section(
        "Trend of a drive over its life.",
        threshold=_f(float, 10.0, "nats, evidence from which a change is detected.", 0, 1e6),
        draws=_f(int, 200, "Draws of a change of the parameters.", 20, 10_000),
        horizon=_f(int, 10_000, "Operations, longest predicted remaining life.", 1, 10**9),
    ),
    report=_section(
        "The sheet of `breaker report`.",
        company=_f(Text | None, None, "Name at the top."),
        simultaneity=_section(
            "Largest difference between the poles; IEC 62271-100: 5 and 3.3 at 50 Hz; null: none.",
            closing=_f(float | None, None, "ms, in closing.", high=100, gt=0),
            opening=_f(float | None, None, "ms, in opening.", high=100, gt=0),
        ),
    ),
)


def defaults(section: type[Section] = Settings) -> dict[str, Any]:
    """Return all settings with their defaults, as nested dictionaries of plain values."""
    return {
        name: defaults(field.annotation) if field.is_required() else deepcopy(field.default)
        for name, field in section.model_fields.items()
    }


TypeEntry = _section(
    "Limits, speeds, linkage ratio and reference record of a type of breaker.",
    limits=(dict[str, Range], {}),
    speeds=(Speeds, {}),
    ratio=(_number(float, 1e-6, 1e6) | None, None),
    reference=(Text | None, None),
)
TypesFile = RootModel[dict[Text, TypeEntry]]


# ---- problems ------------------------------------------------------------------------------------


def problems(section: type[Section], content: Any) -> dict[str, str]:
    """Return problems in the content of a section by key; a text continues after the key."""
    wrong: dict[str, str] = {}
    try:
        section.model_validate(content)
    except ValidationError as error:
        for failure in error.errors(include_url=False):
            if failure["type"] != "missing" or failure["loc"][0] != "by_motion":  # only differences
                wrong.setdefault(*_problem(failure, content))
    return wrong


def _problem(failure: Mapping, content: Any) -> tuple[str, str]:
    """Return the key of an error of pydantic, and the problem of its value in words."""
    place, kind = failure["loc"], failure["type"]
    words = failure["msg"].removeprefix("Value error, ").partition(" or instance of")[0]
    words = re.sub("^(Input|String|List|Dictionary) should", "must", words).removesuffix(".") + "."
    if kind in ("missing", "extra_forbidden"):
        return _dotted(place), "is missing." if kind == "missing" else "is not a known key."
    if kind == "invalid_key" or place[-1] == "[key]":
        named = kind not in ("invalid_key", "string_type")
        remedy = words if named else "Write numbers with a point, such as 1.3, and quote texts."
        return _dotted(place[: -(place[-1] == "[key]") or None]), f"is not a known key: {remedy}"
    length, value = 0, content
    for part in place:  # after the key, pydantic appends the type that it tried
        try:
            value = value[part]
        except (KeyError, IndexError, TypeError):
            break
        length += 1
    shown = json.dumps(value, ensure_ascii=False, default=str, skipkeys=True)
    shown = f"{shown[:57]}..." if len(shown) > 60 else shown
    return _dotted(place[:length]), f"is {shown}: {words}"


def _dotted(key: tuple[str | int, ...]) -> str:
    """Write a key as ``network.summary.kernels[0]``."""
    parts = (f"[{part}]" if type(part) is int else f".{part}" for part in key)
    return "".join(parts).removeprefix(".")
