"""Every figure draws what it is given, is labelled, and follows the one style."""

from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import FillBetweenPolyCollection, LineCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from breaker.figures import evolution, loss, pairs, predictive, style, validation
from breaker.mechanism.parameters import outputs
from breaker.model.randomness import generator
from breaker.validation import (
    correlation,
    judge_draws,
    judge_ranks,
    prior_check,
    ranks,
    recovery,
    scores,
)

NAMES = [output.name for output in outputs(onset=True)]
FOUR = ["mu", "k_a", "f", "onset"]
TIME = np.linspace(-2.0, 58.0, 31)
NOISE_SD = 0.1


def inferred(curves=60, draws=40):
    """Draws and truth of all eight outputs, from exact normal posteriors in logarithms."""
    rng = generator(4, "test", "figures")
    truth = rng.standard_normal((curves, 8))
    mean = (truth + rng.standard_normal(truth.shape)) / 2
    values = mean[:, None] + np.sqrt(0.5) * rng.standard_normal((curves, draws, 8))
    return np.exp(0.2 * values), np.exp(0.2 * truth)


def curves(count, dim):
    rng = generator(5, "test", "curves")
    rise = 14.0 / (1.0 + np.exp(-(TIME - 8.0) / 2.0))
    travel = rise * rng.uniform(0.9, 1.1, (count, 1))
    noisy = travel + NOISE_SD * rng.standard_normal(travel.shape)
    both = {"median": travel, "lower": travel - 0.2, "upper": travel + 0.2, "travel": noisy}
    return xr.Dataset({name: ((dim, "time"), v) for name, v in both.items()}, {"time": TIME})


def draw_prior_predictive(motion, names):
    prior = curves(50, "curve")
    measured = curves(3, "operation").assign_coords(operation=[1, 50, 100])
    check = prior_check(prior.travel.values, measured.travel.values)
    return predictive.prior_predictive(prior, check, measured, motion=motion)


def draw_loss(motion, names, *, convergence=True, best=200):
    steps, at = np.arange(1, 401), np.arange(100, 401, 100)
    history = xr.Dataset(
        {
            "training_loss": ("step", 0.3 + np.exp(-steps / 50)),
            "learning_rate": ("step", 1e-3 * np.cos(steps / 400)),
            "validation_loss": ("evaluation", 0.31 + np.exp(-at / 50)),
            "evaluation_step": ("evaluation", at),
        },
        {"step": steps},
        {"best_step": best, "held_out_log_density": 3.42, "held_out_log_density_se": 0.05},
    )
    solver = xr.Dataset(
        {
            "mean_difference": ("solver_steps", [0.1, 0.03, 0.01]),
            "max_difference": ("solver_steps", [1.0, 0.4, 0.1]),
            "density_difference": ("solver_steps", [0.3, 0.08, 0.02]),
        },
        {"solver_steps": [2, 4, 8]},
        {"chosen_steps": 4, "chosen_density_steps": 8, "reference_steps": 64},
    )
    return loss.loss(history, solver if convergence else None, motion=motion)


def draw_sbc(motion, names):
    draws, truth = inferred()
    judged = judge_ranks(ranks(draws, truth)[:, : len(names)], draws.shape[1])
    return validation.sbc(judged, names, motion=motion)


def draw_contraction(motion, names, *, limit=True):
    draws, truth = (values[..., : len(names)] for values in inferred())
    judged = scores(draws, truth, prior_sd=np.full(len(names), 0.2), log=np.full(len(names), True))
    exact = np.full(len(names), 0.5) if limit else None
    return validation.contraction(judged, names, motion=motion, limit=exact)


def draw_recovery(motion, names):
    draws, truth = (values[..., : len(names)] for values in inferred())
    return validation.recovery(recovery(draws, truth), names, motion=motion)


def draw_pairs(motion, names):
    columns = [NAMES.index(name) for name in names]
    draws, truth = (values[..., columns] for values in inferred())
    strength = correlation(draws[0], log=np.full(len(names), True))
    return pairs.pairs(truth, draws[0], truth[0], names, motion=motion, correlation=strength)


def draw_posterior_predictive(motion, names):
    data = curves(4, "curve").rename(travel="measured")
    data = data.assign(share_inside=("curve", [0.91, 0.93, 0.95, 0.97]))
    return predictive.posterior_predictive(data, motion=motion, noise_sd=NOISE_SD)


def draw_endurance_predictive(motion, names, *, noise_sd=NOISE_SD, stages=4):
    data = curves(stages, "stage").assign_coords(operation=("stage", np.arange(stages) * 100 + 1))
    data = data.assign(share_inside=("stage", np.linspace(0.9, 1.0, stages)))
    return predictive.endurance_predictive(data, motion=motion, noise_sd=noise_sd)


def draw_evolution(motion, names, *, misfit=True, effective=True, corrected=True):
    draws, _ = (values[..., : len(names)] for values in inferred())
    summary = recovery(draws, draws[:, 0])
    accepted = np.arange(len(draws)) % 7 != 3
    bands = {
        name: (("operation", "output", "bound"), getattr(summary, name))
        for name in ("interval_50", "interval_95")
    }
    data = xr.Dataset(
        {"median": (("operation", "output"), summary.median), **bands},
        {"operation": np.arange(1, len(draws) + 1), "output": names, "bound": ["lower", "upper"]},
    )
    data = data.where(xr.DataArray(accepted, dims="operation"))  # rejected: not a number
    data = data.assign(
        accepted=("operation", accepted),
        misfit=("operation", accepted & misfit),
        outside_prior=("operation", np.arange(len(draws)) > 55),
    )
    if corrected:  # 12 are not resolved, two of them because they were rejected
        data = data.assign(resolved=("operation", np.arange(len(draws)) % 5 != 0))
    values = xr.DataArray(
        np.ones((3, 7)),
        dims=("stage", "output"),
        coords={"output": NAMES[:7], "operation": ("stage", [1, 30, 60])},
    )
    return evolution.evolution(data, motion=motion, effective=values if effective else None)


# Name of the figure, what draws it, and its number of panels with q outputs.
FIGURES = {
    "prior_predictive": (draw_prior_predictive, lambda q: 1),
    "loss": (draw_loss, lambda q: 4),
    "sbc": (draw_sbc, lambda q: q),
    "contraction": (draw_contraction, lambda q: q),
    "recovery": (draw_recovery, lambda q: q),
    "pairs": (draw_pairs, lambda q: q * q),
    "posterior_predictive": (draw_posterior_predictive, lambda q: 8),
    "endurance_predictive": (draw_endurance_predictive, lambda q: 8),
    "evolution": (draw_evolution, lambda q: q),
}


@pytest.fixture(scope="module")
def drawn():
    """All figures, drawn once. Pairs of four outputs do for eight: 64 panels take five seconds."""
    names = {name: FOUR if name == "pairs" else NAMES for name in FIGURES}
    return {name: draw("closing", names[name]) for name, (draw, _) in FIGURES.items()}


def words(figure):
    """All texts of a figure that are not ticks."""
    texts = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    for axis in figure.axes:
        texts += [axis.get_title(loc) for loc in ("left", "center", "right")]
        texts += [axis.get_xlabel(), axis.get_ylabel()]
        if axis.get_legend() is not None:
            texts += [text.get_text() for text in axis.get_legend().get_texts()]
    return "\n".join([figure.get_suptitle(), *texts])


@pytest.mark.parametrize("name", FIGURES)
def test_panels_title_and_legend(drawn, name):
    figure = drawn[name]
    assert isinstance(figure, Figure)
    assert len(figure.axes) == FIGURES[name][1](4 if name == "pairs" else 8)
    assert figure.get_suptitle().startswith("Closing: ")
    assert figure.legends or any(axis.get_legend() for axis in figure.axes)


@pytest.mark.parametrize("name", ["sbc", "contraction", "recovery", "pairs", "evolution"])
def test_without_onset(name):
    """The paper's own setting has no onset; three outputs do for seven. And the other motion."""
    figure = FIGURES[name][0]("opening", NAMES[:3])
    assert len(figure.axes) == FIGURES[name][1](3)
    assert figure.get_suptitle().startswith("Opening: ")
    assert r"$t_0$" not in words(figure)


@pytest.mark.parametrize(
    ("name", "labels"),
    [
        ("prior_predictive", ["time (ms)", "travel (mm)", "pointwise 95 % band", "operation 50"]),
        ("loss", ["training step", "learning rate", "step 200", "4 steps"]),
        (
            "loss",
            [
                "difference from 64 steps",
                "draws, mean (posterior sd)",
                "log density, mean (nats)",
                "held-out log density 3.420 ± 0.050 nats",
            ],
        ),
        (
            "sbc",
            ["ECDF difference", "rank of the truth", "95 %", "calibrated: all 8 outputs inside"],
        ),
        ("contraction", ["z-score", "contraction", "±3", "mean 0.", "exact 0.500"]),
        ("recovery", ["true $k_a$ (1/ms²)", "inferred $L$ (mm)", "95 % interval"]),
        ("pairs", ["prior", "posterior", "truth", "$f$ (mm/ms²)", "$t_0$ (ms)"]),
        (
            "posterior_predictive",
            ["time (ms)", "travel (mm)", "(noise sd)", "record 4: 97 % in the band"],
        ),
        ("endurance_predictive", ["operation 301", "100 % of the main motion", "(noise sd)"]),
        ("evolution", ["operation", "$\\gamma_a$ (1/ms)", "$L$ (mm)", "effective values"]),
        ("evolution", ["50 % interval", "51 of 60", "rejected by the reader: 9 of 60"]),
        ("evolution", ["not resolved: exact posterior not reached: 10 of 60"]),
    ],
)
def test_labels_with_units(drawn, name, labels):
    text = words(drawn[name])
    assert [label for label in labels if label not in text] == []


def parameter_colours(figure):
    """Colour of the data of each parameter's panel: that of most coloured artists in it."""
    neutral = {style.MEASURED, style.MODEL, style.PRIOR, style.REFERENCE, style.WARNING}
    found = {}
    for axis in figure.axes:
        title = axis.get_title() or axis.get_title("left")
        artists = [line.get_color() for line in axis.lines]
        artists += [patch.get_facecolor() for patch in axis.patches]
        colours = {to_hex(each).upper() for each in artists} - neutral - {"#000000"}
        for output in outputs(onset=True):
            if title.split("  ")[0] == output.symbol:
                found[output.name] = colours
    return found


@pytest.mark.parametrize("name", ["sbc", "contraction", "recovery", "pairs", "evolution"])
def test_same_parameter_same_colour(drawn, name):
    names = FOUR if name == "pairs" else NAMES
    assert parameter_colours(drawn[name]) == {each: {style.COLOURS[each]} for each in names}


# Machado, Oliveira & Fernandes 2009, severity 1.0: what a deficient eye sees, in linear RGB.
SIGHT = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


def lab(colour, sight):
    """CIELAB of a colour as it is seen, from sRGB with white point D65."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.asarray(sight) @ linear, 0.0, 1.0)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(np.maximum(to_xyz @ seen / [0.9505, 1.0, 1.089], 1e-9))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("sight", SIGHT)
def test_colours_stay_apart(sight):
    """15 CIELAB units, six times a just noticeable difference; the closest pair of the palette of
    Okabe and Ito is 16 apart."""
    seen = {name: lab(colour, SIGHT[sight]) for name, colour in style.COLOURS.items()}
    distances = {
        (a, b): np.linalg.norm(seen[a] - seen[b]) for a, b in combinations(style.COLOURS, 2)
    }
    assert {pair: d for pair, d in distances.items() if d < 15} == {}


def test_settings_are_left_alone_and_not_taken_over():
    with mpl.rc_context({"font.size": 31.0, "axes.grid": False, "figure.dpi": 40}):
        before = dict(mpl.rcParams)
        figure = draw_prior_predictive("opening", NAMES)
        assert dict(mpl.rcParams) == before
    assert figure.axes[0].xaxis.label.get_size() < 12
    assert figure.dpi == 150


@pytest.mark.parametrize("name", FIGURES)
def test_nothing_overlaps(drawn, name):
    assert_nothing_overlaps(drawn[name])


def assert_nothing_overlaps(figure):
    """Panels with their labels, legend and title share no more than a line's width."""
    boxes = {f"panel {i}": axis.get_tightbbox() for i, axis in enumerate(figure.axes)}
    boxes |= {f"legend {i}": legend.get_window_extent() for i, legend in enumerate(figure.legends)}
    boxes["title"] = figure._suptitle.get_window_extent()
    page = figure.bbox.padded(3.0)
    off_page = [
        key
        for key, box in boxes.items()
        if not (page.contains(box.x0, box.y0) and page.contains(box.x1, box.y1))
    ]
    assert off_page == []
    overlaps = []
    for (a, first), (b, second) in combinations(boxes.items(), 2):
        width = min(first.x1, second.x1) - max(first.x0, second.x0)
        height = min(first.y1, second.y1) - max(first.y0, second.y0)
        if width > 3.0 and height > 3.0:  # pixels, of 150 an inch
            overlaps.append((a, b, round(width), round(height)))
    assert overlaps == []


def test_flags_leave_the_data_free(drawn):
    """Even with every operation flagged, the strips end below the bands."""
    for axis in drawn["evolution"].axes:
        strips = [each for each in axis.collections if isinstance(each, LineCollection)]
        bands = [each for each in axis.collections if isinstance(each, FillBetweenPolyCollection)]
        height = max(segment[:, 1].max() for strip in strips for segment in strip.get_segments())
        low, high = axis.get_ylim()
        lowest = min(band.get_datalim(axis.transData).y0 for band in bands)
        assert 0.0 < height < (lowest - low) / (high - low)


def test_flags_are_drawn_only_where_they_are():
    few = {"misfit": False, "effective": False, "corrected": False}
    text = words(draw_evolution("closing", NAMES[:2], **few))
    assert "does not fit" not in text
    assert "effective values" not in text
    assert "not resolved" not in text
    assert "rejected by the reader" in text


def test_flags_are_those_of_the_data(drawn):
    """Each strip, from the foot up, has a tick at each flagged operation and nowhere else."""
    i = np.arange(60)
    rejected = i % 7 == 3
    flagged = [~rejected, i > 55, (i % 5 == 0) & ~rejected, rejected]
    for axis in drawn["evolution"].axes:
        strips = [each for each in axis.collections if isinstance(each, LineCollection)]
        at = [{segment[0, 0] for segment in strip.get_segments()} for strip in strips]
        assert at == [set((i[flag] + 1).tolist()) for flag in flagged]
        assert len({to_hex(strip.get_color()[0]) for strip in strips}) == 4


def test_sbc_names_what_is_outside():
    draws, truth = inferred(curves=300)
    draws[..., 2] *= 1.2
    judged = judge_draws(draws, truth)
    figure = validation.sbc(judged, NAMES, motion="closing", subject="calibration of files")
    assert "calibration of files" in figure.get_suptitle()
    assert "NOT calibrated: $k_b$ outside the band" in figure.get_suptitle()
    assert figure._suptitle.get_color() == style.WARNING
    assert "outside by 0." in figure.axes[2].get_title()
    assert "inside" in figure.axes[3].get_title()


def test_figures_without_the_optional_parts():
    assert len(draw_loss("closing", NAMES, convergence=False).axes) == 3
    assert "exact" not in words(draw_contraction("closing", NAMES[:2], limit=False))
    assert len(draw_endurance_predictive("closing", NAMES, stages=1).axes) == 2
    assert len(draw_endurance_predictive("closing", NAMES, stages=3).axes) == 6


def test_unusable_input_is_refused():
    with pytest.raises(ValueError, match="no source is called 'Closing'"):
        draw_prior_predictive("Closing", NAMES)
    with pytest.raises(ValueError, match="no output is called 'k_1'"):
        draw_recovery("closing", ["mu", "k_1"])
    with pytest.raises(ValueError, match="best_step 150"):
        draw_loss("closing", NAMES, best=150)
    with pytest.raises(ValueError, match="noise sd above zero"):
        draw_endurance_predictive("closing", NAMES, noise_sd=0.0)
