"""Every setting: its default, type, bounds and one sentence, in one class for each section.

``make defaults`` writes the files in ``config``, the JSON schema and the page of settings from
these classes, and ``checking`` compares a configuration with them.
"""

from collections.abc import Callable
from copy import deepcopy
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from breaker.model.parameters import NAMES
from breaker.model.quantities import speeds_of

ADVANCED = ("network", "training", "by_motion", "bank", "family", "validation", "simulated_test")
"""Sections that hardly any user changes, which are in ``config/advanced.yaml``."""


class Section(BaseModel):
    """A section: no unknown keys, and no number from a text or the like."""

    model_config = ConfigDict(
        strict=True, extra="forbid", allow_inf_nan=False, defer_build=True, validate_default=False
    )


def _f(default: Any, text: str, low: float | None = None, high: float | None = None, **more: Any):
    """Return a setting: default, description, smallest and largest value, and other bounds."""
    return Field(default, description=text, ge=low, le=high, **more)


def _text(most: int = 1000, **more: Any) -> Any:
    return Annotated[str, Field(min_length=1, max_length=most, **more)]


def _number(kind: type, low: float | None = None, high: float | None = None, **more: Any) -> Any:
    return Annotated[kind, Field(ge=low, le=high, **more)]


def _list(entry: Any, least: int, most: int) -> Any:
    return Annotated[list[entry], Field(min_length=least, max_length=most)]


def _where(kind: Any, holds: Callable[[Any], bool], text: str) -> Any:
    def check(value: Any) -> Any:
        if not holds(value):
            raise ValueError(text)
        return value

    return Annotated[kind, AfterValidator(check)]


Motion = Literal["closing", "opening"]
Function = _text(200, pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$")
Summary = _text(200, pattern=r"^(time_series|[A-Za-z_][\w.]*:[A-Za-z_]\w*)$")
Column = _text(200) | _number(int, 1, 1000)
Trigger = _text(200) | _number(int, 0, 1000)
Amount = _number(float, -1e6, 1e6)
Known = _where(
    _list(Amount, 2, 2), lambda pair: pair[1] > 0.0, "the standard deviation must be above 0"
)
Points = _list(_text(100), 2, 2)
SpeedName = _text(100, pattern=r"^(closing|opening)_speed(_[a-z0-9_]+)?$")
Bound = Amount | _text(14, pattern=r"^[+-]?[0-9]{1,4}(\.[0-9]{1,6})? ?%$")
Tolerance = _number(float, high=1e6, gt=0) | _text(
    20, pattern=r"^(±|\+/?-)? ?[0-9]{1,6}(\.[0-9]{1,6})? ?%?$"
)
Text = _text()
Words = Annotated[str, Field(max_length=400)]
Unit = Literal["mm", "cm", "m", "um", "inch", "deg", "rad", "V", "counts", "%"]
Stroke = _list(_number(float, high=1000, gt=0), 2, 2)
Sizes = _list(_number(int, 1, 10_000), 1, 16)
Hidden = _list(_number(int, 1, 512), 1, 4)
Optimiser = Literal["muon", "muon_edges", "adamw"]
Posterior = Literal["amortised", "corrected"]
_ORDERED = (lambda ends: ends[0] <= ends[1], "the first must not exceed the second")
Numbers = _where(_list(_number(int, 0, 10**9), 2, 2), *_ORDERED)
Range = _where(_list(_number(float, -100, 100), 2, 2), *_ORDERED)
Motions = _where(_list(Motion, 1, 2), lambda some: len({*some}) == len(some), "no motion twice")
Interval = _text(
    40,
    pattern=r"^(every operation|([0-9]{1,8}\.)?[0-9]{0,8}[1-9][0-9]{0,8} (operation|year)s?)$",
)
Renewed = Literal[("all", "transducer", *NAMES)]


class Model(Section):
    """Functions of your own in place of the simulator or the prior."""

    simulator: Function | None = _f(None, "module:function of a simulator; null: paper's drive.")
    prior: Function | None = _f(None, "module:function of a prior; null: the prior below.")


class LogNormal(Section):
    """A log-normal distribution."""

    median: float = _f(1.0, "Median before the conditioning, in the parameter's unit.", 1e-4, 1000)
    log_sd: float = _f(0.2, "Standard deviation of the natural logarithm.", 1e-3, 1)


def _prior(median: float, log_sd: float, text: str) -> Any:
    return Field({"median": median, "log_sd": log_sd}, description=text)


class Prior(Section):
    """Prior of the seven parameters: independent log-normals, conditioned on a contact that stays
    pressed, f > k_a L. A log_sd of 0.2 is about 20 %.
    """

    mu: LogNormal = _prior(2.0, 0.2, "Mass ratio of drive to contact, M_a / M_b.")
    k_a: LogNormal = _prior(0.045, 0.15, "1/ms^2, opening spring on the main shaft.")
    k_b: LogNormal = _prior(0.04, 0.2, "1/ms^2, contact spring in the pushrod.")
    gamma_a: LogNormal = _prior(0.3, 0.2, "1/ms, damping of the drive.")
    gamma_b: LogNormal = _prior(0.12, 0.4, "1/ms, damping of the contact spring.")
    f: LogNormal = _prior(0.75, 0.1, "mm/ms^2, closing force per drive mass.")
    L: LogNormal = _prior(10.0, 0.05, "mm, contact gap.")


class Sensor(Section):
    """Travel sensor: its time grid around the nominal start of motion, and its errors."""

    start: float = _f(-2.0, "ms, first sample, before the nominal start.", -1000, lt=0)
    stop: float = _f(58.0, "ms, last sample.", 1, 10_000)
    samples: int = _f(151, "Number of samples of a record, both ends included.", 4, 2000)
    noise_sd: float = _f(0.1, "mm, standard deviation of the noise of one sample.", 1e-4, 10)
    onset_sd: float = _f(0.3, "ms, sd of the start of motion; 0 means no onset.", 0, 20)
    zero_sd: float = _f(0.1, "mm, sd of the offset of a record; 0 means none.", 0, 20)


class Size(Section):
    """Size of the drive relative to the default drive. All shipped networks are scaled by it.
    With default prior, sensor and size, `breaker infer` reads the size from the records.
    """

    lengths: float = _f(1.0, "Factor on lengths: 10 for a stroke of about 150 mm.", 0.01, 100)
    times: float = _f(1.0, "Factor on times: 4 if a motion takes four times as long.", 0.01, 100)


class Format(Section):
    """Layout of a curve file. `breaker inspect FILE` proposes it."""

    encoding: str = _f("utf-8", "Encoding of the text.", min_length=1, max_length=50)
    delimiter: Literal[",", ";", "\t", "|", " "] = _f(",", "Character between columns.")
    decimal: Literal[".", ","] = _f(".", "Decimal sign of numbers.")
    time_column: Column | None = _f("time", "Name or number of the time column; null without one.")
    time_unit: Literal["s", "ms", "us"] = _f("s", "Unit of the time.")
    rate: float | None = _f(None, "kHz, sampling rate; required without a time column.", 0.95, 1000)
    travel_column: Column = _f("travel", "Name or number of the travel column.")
    travel_unit: Unit = _f("mm", "Unit of the travel; all but lengths need ratio or table.")
    ratio: float | None = _f(None, "mm per travel_unit, such as the ratio of a lever.", 1e-6, 1e6)
    table: Text | None = _f(None, "CSV file of two columns, reading in travel_unit and mm.")
    zero: Amount | Literal["rest"] = _f(0.0, "Reading of the open breaker; rest: of each record.")
    sign: Literal[1, -1] = _f(1, "1 if the reading grows towards closed, -1 if it falls.")
    quantum: float | None = _f(None, "mm, step of the reading; null finds it.", 0, 10)
    samples: int | None = _f(None, "Usual number of samples; others get a remark.", 2, 10_000_000)
    stroke: Stroke | None = _f(None, "mm, smallest and largest stroke; null: that of any breaker.")
    contact_column: Column | None = _f(None, "Name or number of the main contact's column.")
    timing_sd: float = _f(0.1, "ms, sd of the times of contact touch and separation.", 0.01, 10)
    trigger_column: Trigger | None = _f(None, "Column of trigger or coil current; 0: at time 0.")
    motor_column: Column | None = _f(None, "Column of the current of the charging motor.")
    missing: float = _f(0.5, "Largest share of missing samples.", 0, 0.8)


class Endurance(Section):
    """Measured curves and their inference."""

    curves: Text | None = _f(None, "Folder of the curve files; null is the simulated test.")
    breaker: Text | None = _f(None, "Breaker to use, if operations.csv has several; null: all.")
    phase: Text | None = _f(None, "Phase to use, if there are several.")
    events: dict[str, _list(Renewed, 0, 9)] = _f(
        {}, "More events of operations.csv, each with what it renews, such as {oil: [gamma_a]}."
    )
    operations_per_job: int = _f(1000, "Operations read and inferred by one job.", 1, 100_000)
    draws: int = _f(500, "Posterior draws of each operation.", 10, 25_000)
    misfit_p_value: float = _f(1e-3, "p-value below which a record is flagged.", gt=0, lt=1)
    format: Format


class SummaryNetwork(Section):
    """Network from a record to features: convolutions, GRU, skip GRU and a linear highway."""

    kind: Summary = _f("time_series", "time_series, or module:function for one of your own.")
    features: int = _f(64, "Features passed to the inference network.", 1, 1024)
    components: int = _f(24, "Linear components of the highway.", 1, 1024)
    channels: Sizes = _f([16], "Output channels of the convolutions, one entry a layer.")
    kernels: Sizes = _f([16], "Kernels of the convolutions, samples.")
    strides: Sizes = _f([16], "Strides of the convolutions, samples.")
    gru_width: int = _f(16, "Width of the GRU.", 1, 1024)
    skip: int = _f(3, "Steps after the convolutions that the skip GRU spans.", 1, 10_000)
    skip_width: int = _f(8, "Width of the skip GRU.", 1, 1024)
    width: int = _f(192, "Width of the residual network that joins the parts.", 1, 1024)
    blocks: int = _f(2, "Blocks of this residual network.", 1, 8)


class FlowMatching(Section):
    """Continuous normalising flow, trained by flow matching."""

    width: int = _f(128, "Width of the residual blocks of the velocity field.", 1, 1024)
    blocks: int = _f(3, "Residual blocks of the velocity field.", 1, 8)


class CouplingFlow(Section):
    """Coupling flow of rational-quadratic splines."""

    transforms: int = _f(4, "Couplings.", 1, 16)
    bins: int = _f(8, "Bins of a spline.", 2, 32)
    hidden: Hidden = _f([96, 96], "Widths of the hidden layers of each coupling's network.")


class InferenceNetwork(Section):
    """Network from features to the posterior; only the section of the chosen kind is used."""

    kind: Literal["coupling_flow", "flow_matching"] = _f("coupling_flow", "Kind of network.")
    flow_matching: FlowMatching
    coupling_flow: CouplingFlow


class Network(Section):
    """Summary and inference network of both motions."""

    summary: SummaryNetwork
    inference: InferenceNetwork


class Training(Section):
    """Training of the networks of both motions."""

    steps: int = _f(2300, "Optimiser steps.", 1, 10_000_000)
    batch: int = _f(1024, "Curves in a step.", 1, 50_000)
    optimiser: Optimiser = _f("muon_edges", "Of hidden matrices; muon_edges: of all matrices.")
    learning_rate: float = _f(0.003, "Highest learning rate.", high=1, gt=0)
    evaluate_every: int = _f(100, "Steps between two evaluations.", 1, 10_000_000)
    checkpoint_every: int = _f(1000, "Steps between two checkpoints.", 1, 10_000_000)
    validation_curves: int = _f(1024, "Curves that choose the best weights.", 1, 1_000_000)
    held_out_curves: int = _f(200, "Curves that judge the density at the end.", 1, 1_000_000)
    threads: int = _f(1, "CPU threads, of each training.", 1, 1024)
    device: Literal["auto", "cpu", "cuda"] = _f("auto", "Device; auto is CUDA if available.")


class OfMotion(Section):
    """Settings of one motion that differ from those of both."""

    network: Network
    training: Training


class Bank(Section):
    """Training bank of each motion: curves without noise, one Zarr store and one job a shard."""

    shards: int = _f(4, "Zarr stores; more of them simulate only the new ones.", 1, 1000)
    curves_per_shard: int = _f(65_536, "Curves in each shard.", 1, 10_000_000)
    online: bool = _f(False, "Whether each batch is simulated anew; the bank then only judges.")


class FamilyNetwork(Section):
    """Networks of a family: a residual network, and a mixture of Gaussians for each output."""

    width: int = _f(256, "Width of the residual network.", 1, 4096)
    blocks: int = _f(3, "Blocks of the residual network.", 0, 100)
    features: int = _f(64, "Features passed to the mixtures.", 1, 4096)
    components: int = _f(6, "Gaussians in the mixture of an output.", 1, 100)
    head: int = _f(48, "Width of the network of an output.", 1, 4096)


class FamilyTraining(Section):
    """Training of the networks of a family; threads and device are those of `training`."""

    steps: int = _f(14_000, "Optimiser steps.", 1, 10_000_000)
    batch: int = _f(1024, "Drives in a step.", 1, 50_000)
    evaluate_every: int = _f(500, "Steps between two evaluations.", 1, 10_000_000)
    checkpoint_every: int = _f(1000, "Steps between two checkpoints.", 1, 10_000_000)
    validation_curves: int = _f(2000, "Drives that choose the best weights.", 1, 1_000_000)
    held_out_curves: int = _f(5000, "Drives of the membership test, and to judge by.", 1, 1_000_000)
    workers: int = _f(0, "Processes that make batches ahead; no weight depends on them.", 0, 1024)


class Family(Section):
    """Family of drives with effects that the model lacks, and the networks trained on it."""

    name: Text = _f("medium_voltage", "medium_voltage, any, or a YAML file of your own.")
    drives: int = _f(200_000, "Drives in the bank, each new and worn, in both motions.", 1, 10**7)
    shards: int = _f(10, "Zarr stores of the bank, one job each.", 1, 1000)
    network: FamilyNetwork
    training: FamilyTraining


class Validation(Section):
    """Curves that no training has seen, and the checks of the posterior on them."""

    curves: int = _f(1000, "Validation curves of a motion.", 10, 100_000)
    draws: int = _f(500, "Posterior draws of each curve.", 10, 100_000)
    seed: int = _f(11, "Seed of these; a second validation has the next one.", 0, 2**32 - 2)
    posterior: Posterior = _f(
        "amortised", "Posterior of figures: amortised (network) or corrected."
    )
    judged_curves: int = _f(1000, "Curves on which both are compared.", 10, 100_000)
    prior_curves: int = _f(2000, "Curves of the prior predictive figure.", 20, 50_000)
    limit_curves: int = _f(1000, "Prior draws of the exact limit of contraction.", 10, 100_000)
    correction_rounds: int = _f(20, "Largest number of rounds of the correction.", 1, 1000)


class SimulatedTest(Section):
    """Simulated endurance test: CSV files of a wearing drive that the model does not fit."""

    operations: int = _f(2000, "Close-open operations until the end of life.", 2, 100_000)


class Limit(Section):
    """A limit: a name, `upper` or `lower`, usually a motion; or quantity, reference, tolerance."""

    name: str = Field("", pattern=r"^[^;\x00-\x1f\x7f-\x9f]+$", max_length=100)
    motion: Motion = "closing"
    of: Literal["model", "record", "change"] = "model"
    since: Literal["new", "event"] = "new"
    upper: dict[str, Bound] = {}
    lower: dict[str, Bound] = {}
    quantity: _text(100) = ""
    reference: Bound = 0.0
    tolerance: Tolerance = 1.0


class Trend(Section):
    """How the life of a drive is followed in its own curves."""

    reference: _number(int, 2, 100_000) | Numbers = _f(
        50, "Number of first records that count as new, or [first, last] number."
    )
    settle: int = _f(50, "Records after these, or a change, before a change counts.", 1, 100_000)
    threshold: float = _f(10.0, "nats, evidence from which a change is detected.", 0, 1e6)
    draws: int = _f(200, "Draws of a change of the parameters.", 20, 10_000)
    horizon: int = _f(10_000, "Operations, longest remaining life that is predicted.", 1, 10**9)


class Planning(Section):
    """When to service: at the operation of least expected cost per operation (docs/decisions.md).
    Costs are in any unit. A service is recommended when it is due within operations or years.
    """

    operations: float = _f(500, "Operations ahead.", 0, 1e9)
    years: float = _f(2.0, "Years ahead, where dates are known.", 0, 100)
    service_cost: float = _f(1.0, "Cost of a planned service.", high=1e12, gt=0)
    failure_cost: float = _f(20.0, "Cost of a failure; more than a service.", 0, 1e12)
    inspection_cost: float = _f(0.1, "Cost of an inspection; none under monitoring.", 0, 1e12)
    inspection: Interval = _f("every operation", "Or 1 year, 100 operations: their interval.")
    sudden_failures: float = _f(0.0015, "Sudden failures of a drive per year; 0: none.", 0, 10)


class Simultaneity(Section):
    """Largest difference between the poles, ms; IEC 62271-100: 5 and 3.3 at 50 Hz; null: none."""

    closing: float | None = _f(None, "ms, in closing.", high=100, gt=0)
    opening: float | None = _f(None, "ms, in opening.", high=100, gt=0)


class Reference(Section):
    """A good record to compare with; the tolerance is in % of the stroke, and null means 5."""

    file: Text | None = _f(None, "File of the record.")
    tolerance: float | None = _f(None, "Half of the band about it, % of the stroke.", gt=0, lt=100)


class Report(Section):
    """The sheet of `breaker report`."""

    company: Text | None = _f(None, "Name at the top.")
    logo: Text | None = _f(None, "PNG file at the top.")
    remarks: _text(4000) | None = _f(None, "Text below the tables.")
    signatures: _list(_text(60), 0, 4) = _f(["tested by", "approved by"], "Lines to sign.")
    simultaneity: Simultaneity
    reference: Reference


class Fleet(Section):
    """Many breakers side by side."""

    breakers_per_job: int = _f(30, "Breakers read and evaluated by one job.", 1, 1000)
    followed: int = _f(150, "Number of operations from which a life is followed.", 2, 1_000_000)


_LIMITS = [
    {"name": "slow_closing", "motion": "closing", "of": "record", "upper": {"travel_time": 9.5}},
    {"name": "slow_opening", "motion": "opening", "of": "record", "upper": {"travel_time": 12.2}},
    {"name": "short_stroke", "motion": "closing", "of": "record", "lower": {"stroke": 14.1}},
    {"name": "stiff_drive", "of": "change", "upper": {"gamma_a": "+15 %"}},
    {"name": "tired_closing", "of": "change", "lower": {"f": "-6 %"}},
]


class Settings(Section):
    """The settings of the workflow and of the command `breaker`."""

    seed: int = _f(1, "Seed of all random numbers but those of the validation.", 0, 2**32 - 1)
    motions: Motions = _f(["closing", "opening"], "Motions to work on: closing, opening or both.")
    model: Model
    prior: Prior
    sensor: Sensor
    size: Size
    contact_lag: dict[Motion, Known] = _f(
        {},
        "Mean and sd of the lag of contacts of a type, by motion, in durations from 10 to 50 % of "
        "the stroke; `breaker fit-prior` writes it for `breaker infer` and `breaker report`.",
    )
    known: dict[str, Known] = _f(
        {},
        "Known values of the drive for `breaker infer`, as in {mu: [2.4, 0.1]}: value and sd.",
    )
    endurance: Endurance
    network: Network
    training: Training
    by_motion: dict[Motion, OfMotion] = _f(
        {"opening": {"training": {"steps": 2850}}},
        "Settings of network and training that differ for one motion: the posterior of an opening "
        "is sharper, so that its training takes more steps.",
    )
    bank: Bank
    family: Family
    validation: Validation
    simulated_test: SimulatedTest
    speeds: Annotated[dict[SpeedName, Points | None], AfterValidator(speeds_of)] = _f(
        {"closing_speed": None, "opening_speed": None},
        "Speeds by name, each the mean between two points, such as [6 mm before touch, touch], "
        "[10 % of stroke, 10 ms after 50 % of stroke] or [20 mm from open, 30 % from closed]; null "
        "is the last 6 mm before contact touch, or the first 6 mm after contact separation.",
    )
    limits: _list(Limit, 1, 100) = _f(
        _LIMITS,
        "Limits, exceeded if all parts are: `upper` values are maxima, `lower` values minima; "
        "`of` is record (measured quantities, such as stroke, travel_time or a speed), change (of "
        "a parameter since new, or since: event, in percent) or model (parameters); a two-sided "
        "limit is {quantity: stroke, reference: 178, tolerance: 3 %}; your list replaces this "
        "example (docs/decisions.md).",
    )
    limits_by_type: dict[str, dict[str, _list(Amount | None, 2, 2)]] = _f(
        {},
        "More limits of a fleet by type of breaker, smallest and largest value of a measured "
        "quantity: {GL 314: {stroke: [178, 184], opening travel_time: [null, 19.5]}}.",
    )
    planning: Planning
    trend: Trend
    report: Report
    fleet: Fleet
    advice: dict[str, Words] = _f(
        {}, "Where to look first, by quantity, in place of the words of shipped/advice.yaml."
    )


def defaults(section: type[Section] = Settings) -> dict[str, Any]:
    """Return every setting with its default, as nested dictionaries of plain values."""
    return {
        name: defaults(field.annotation) if field.is_required() else deepcopy(field.default)
        for name, field in section.model_fields.items()
    }


Effect = Literal[
    *("lever_turn", "lever_lean", "dry_friction", "opening_preload", "contact_preload", "build_up"),
    *("train_mass", "train_friction", "restitution", "force_fall", "drag", "linkage", "growth"),
    *("stick", "slip", "load", "opening_progress", "drag_power", "reading", "way_force"),
    *("time_force", "speed_force"),
]
Stop = Literal["closing_stop", "opening_stop"]
StopPart = Literal["reach", "damping", "power", "depth", "stiffness", "profile"]
Worn = Literal[(*NAMES, *get_args(Effect), "closing_stop.damping", "opening_stop.damping")]


class Wear(Section):
    """How many parameters and effects change, of one kind of wear or of several with shares."""

    parameters: Numbers = [0, 0]
    elements: Numbers = [0, 0]
    kinds: dict[
        Literal["none", "sparse", "dense"],
        dict[Literal["share", "parameters", "elements"], float | Numbers],
    ] = {}
    smallest: float = 1.0
    change: dict[Worn, Range]


class FamilyFile(Section):
    """Definition of a family of drives."""

    strength: Range | float
    contacts: dict[Literal["elastic", "held", "sliding"], float] = {}
    held_preload: Range = [0.0, 0.0]
    touch: Range = [0.0, 1.0]
    effects: dict[Effect | Stop, Range | dict[StopPart, Range]]
    wear: Wear
