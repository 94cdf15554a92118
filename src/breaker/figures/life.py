"""Health, operations left and changes, over the operations of a life.

``life`` is the result of ``forecast_of``, ``standing`` the result of ``states_of`` for it.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import about, first_of, in_digits, in_percent, span
from breaker.diagnosis.sentences import say
from breaker.figures import panels as p
from breaker.figures import style

_KINDS = {"rate": "the wear changed its rate", "step": "a sudden fault", "event": "known work"}


@style.styled
def health(life: xr.Dataset, standing: xr.Dataset) -> Figure:
    """Draw one panel per limit: probability that it is exceeded, and its state in a strip below."""
    operation, titles = standing["operation"].values, []
    for j, words in enumerate(life["words"].values):
        one = standing.isel(limit=j, operation=-1)
        name, beyond = [*p.STATES][one["state"].item()], one["p_exceeded"].item()
        now = f"{name}: {in_percent(beyond)} beyond it" if np.isfinite(beyond) else name
        if np.isfinite(one["certain"].item()):
            now = say("life-certain", certain=one["certain"].item(), crossed=one["crossed"].item())
        titles.append(f"{words}\n{now}")
    figure, axes = p.limit_panels(standing, titles, height=2.5, sharex=True, sharey=True)
    for j, axis in enumerate(axes):
        one = standing.isel(limit=j)
        look = {"lw": 1.8, "ms": 2.0, "mew": 0, "label": "probability"}
        axis.plot(operation, one["p_exceeded"], ".-", color=style.MODEL, **look)
        p.state_strip(axis, operation, one["state"].values)
        if np.isfinite(one["certain"].item()):
            look = {"color": style.WARNING, "lw": 1.4}
            label = "crossed: likelier than not from here on"
            axis.axvline(one["crossed"].item(), ls=":", label=label, **look)
            axis.axvline(one["certain"].item(), label="certain from here on", **look)
    axes[0].set(ylim=(-0.13, 1.05), yticks=np.linspace(0.0, 1.0, 6))
    p.label_outer(axes, "operation", "probability")
    over = int(standing["certain"].notnull().sum())
    count = f"{over} of {len(axes)} limits are exceeded" if over else "No limit is exceeded"
    finding = f"{count} after operation {operation[-1]:,}"
    style.title(figure, finding, "probability that each limit is exceeded", failed=over > 0)
    p.legend_below(figure, columns=4)
    return figure


@style.styled
def remaining_life(
    life: xr.Dataset, standing: xr.Dataset, truth: xr.Dataset | None = None
) -> Figure:
    """Draw one panel per limit: operations left, recommended service, and true operations left.

    ``truth`` of a simulated life has ``failure (limit)``, the first operation beyond a limit, and
    ``held``, the result of ``coverage``.
    """
    known = (standing["state"] > [*p.STATES].index("unknown")).any("operation").values
    vague = ", ".join(p.spoken(name) for name in standing["limit"].values[~known])
    note = f"Too little is known to draw: {vague}." if vague else ""
    if not known.any():
        return p.empty("The operations left until a limit are not known", note)
    predicted = life.sel(asked=slice(life.attrs["reported_from"], None)).isel(limit=known)
    standing = standing.isel(limit=known)
    titles = predicted["words"].values.astype(object)
    if truth is not None:
        truth = truth.sel(limit=predicted["limit"].values)
        for j, share in enumerate(truth["held"].values):
            if np.isfinite(share):
                share = in_percent(share)
                titles[j] += f"\nthe interval contains the truth at {share} of the operations"
    figure, axes = p.limit_panels(predicted, titles, height=3.0, sharex=True)
    for j, axis in enumerate(axes):
        failure = np.nan if truth is None else truth["failure"].values[j]
        _left(axis, predicted["remaining"].isel(limit=j), standing.isel(limit=j), failure)
        axis.set_ylabel("operations left")
    shows = f"operations left until a limit is exceeded\n{note}"
    style.title(figure, _next(standing.isel(operation=-1), truth), shows)
    p.legend_below(figure, columns=4)
    return figure


def coverage(life: xr.Dataset, failure: Sequence[float]) -> list[float]:
    """Return the share of operations whose 90 % interval contains the true number left until each
    limit, ``(limit,)``, from the first prediction until the drive exceeds the limit at ``failure``
    ``(limit,)``; nan without such operations.
    """
    predicted = life.sel(asked=slice(life.attrs["reported_from"], None))
    intervals = predicted.remaining.transpose("limit", "asked", "quantile").values
    shares = []
    for end, values in zip(failure, intervals, strict=True):
        known = (predicted.asked.values < end) & np.isfinite(values[:, 0])
        left, (low, _, high) = end - predicted.asked.values[known], values[known].T
        shares.append(float(((low <= left) & (left <= high)).mean()) if known.any() else np.nan)
    return shares


def _next(last: xr.Dataset, truth: xr.Dataset | None) -> str:
    """Return a headline: how often intervals contain the truth, or which limit is next."""
    if truth is not None and (shares := truth["held"].values[truth["held"].notnull()]).size:
        ends = p.from_to([in_percent(shares.min()), in_percent(shares.max())])
        return f"90 % intervals contain the truth at {ends} of the operations, limit by limit"
    k = int(np.argmin(last["remaining"].isel(quantile=1).fillna(np.inf).values))
    low, middle, high = last["remaining"].values[k]
    if not np.isfinite(middle):
        return "No limit will be exceeded within the horizon"
    left = f"{about(middle)} ({span(low, high)})"
    return f"Next: {p.spoken(last['limit'].values[k])}, operations left: {left}"


def _left(axis: Axes, predicted: xr.DataArray, standing: xr.Dataset, failure: float) -> None:
    """Draw band, median, recommended service and truth, with states at the foot of the panel."""
    operation = standing["operation"].values
    before = operation[operation <= failure]
    low, middle, high = predicted.transpose("quantile", "asked").values
    usual = np.nanquantile(np.append(middle[np.isfinite(middle)], 1.0), 0.95)
    top = 1.25 * max(usual, (failure - before).max(initial=0.0), 1.0)
    low, high = (np.minimum(bound, 10.0 * top) for bound in (low, high))  # beyond the panel
    look = {"color": style.CORRECTED, "label": "90 % interval", "lw": 0.6, "alpha": 0.25}
    axis.fill_between(predicted["asked"].values, low, high, **look)
    look = {"lw": 1.8, "ms": 3.0, "mew": 0, "label": "median"}
    axis.plot(predicted["asked"], middle, ".-", color=style.CORRECTED, **look)
    # Operations until a planned service, until the limit is exceeded.
    ahead = np.maximum(standing["service_by"] - standing["operation"], 0.0)
    over = standing["remaining"].isel(quantile=-1) == 0.0
    service = ahead.where(np.isfinite(ahead) & ~over).values
    look = {"color": style.SERVICE, "lw": 1.4, "drawstyle": "steps-post"}
    look["label"] = "until the service" if np.isfinite(service).any() else None
    axis.plot(standing["operation"], service, **look)
    if before.size:
        look = {"ls": "--", "lw": 1.2, "zorder": 2.5, "label": "truth"}
        axis.plot(before, failure - before, color=style.MEASURED, **look)
    p.state_strip(axis, standing["operation"].values, standing["state"].values)
    axis.set_ylim(-0.06 * top, top)
    axis.yaxis.set_major_formatter("{x:,.0f}")
    if not np.isfinite(middle).any() and not before.size:
        axis.text(0.5, 0.5, "beyond the horizon", transform=axis.transAxes, ha="center")


@style.styled
def changepoint(life: xr.Dataset) -> Figure:
    """Draw the evidence for a change, weights of records, and changes; describe the last four."""
    figure = style.new_figure(11.0, 6.4)
    evidence, weight = figure.subplots(2, 1, sharex=True, height_ratios=(1.5, 1.0))
    _evidence(evidence, life)
    look = {"ms": 2.2, "mew": 0, "alpha": 0.6}
    weight.plot(life["operation"], life["weight"], "o", color=style.MODEL, **look)
    weight.set(ylim=(0.0, None), ylabel="weight", xlabel="operation")
    weight.set_title("weight of each record: low where it is off the trend", loc="left")
    weight.xaxis.set_major_formatter("{x:,.0f}")
    for axis in (evidence, weight):
        p.change_lines(axis, life)
        axis.margins(x=0.01)
    lines = [_change_words(life.isel(change=k), k + 1) for k in range(life.sizes["change"])]
    unknown = life["kind"].values != "event"
    starts = [f"{start:,}" for start in life["start"].values[unknown]]
    finding = f"Changes found at operation {first_of(starts, 4)}"
    finding = finding if starts else f"No change is found in {life.sizes['operation']:,} operations"
    style.title(figure, finding, "\n".join(lines[-4:]))
    p.legend_below(figure, columns=5)
    return figure


def _change_words(change: xr.Dataset, number: int) -> str:
    """Return a change in words: its kind, its operation, and the operation that detected it."""
    start, earliest, latest, noticed = (
        f"{change[name].item():,}" for name in ("start", "earliest", "latest", "noticed")
    )
    words = f"{number}: {_KINDS[change['kind'].item()]} at operation {start}"
    if change["kind"].item() != "event":
        words += f", 90 %: {earliest} to {latest}, noticed at {noticed}"
    return p.spoken(words)


def _evidence(axis: Axes, life: xr.Dataset) -> None:
    """Draw the evidence for a change, linear up to the threshold and logarithmic above it."""
    threshold = life.attrs["threshold"]
    axis.plot(life["operation"], life["evidence"], color=style.MEASURED, lw=1.0)
    look = {"ls": "--", "label": f"threshold {in_digits(threshold, 4)} nats"}
    axis.axhline(threshold, color=style.REFERENCE, lw=1.0, **look)
    noticed = life["noticed"].values[life["kind"].values != "event"]
    look = {"ms": 9, "mec": "w", "label": "change noticed" if noticed.size else None}
    axis.plot(noticed, np.full(noticed.shape, threshold), "v", color=style.CHANGED, **look)
    axis.set_yscale("symlog", linthresh=threshold)
    axis.set_ylim(top=max(2.0 * threshold, 1.2 * life["evidence"].max().item()))
    axis.yaxis.set_major_formatter("{x:g}")
    axis.set_ylabel("evidence (nats)")
    axis.set_title("evidence for a change that is not noticed yet", loc="left", pad=16.0)
    for k, start in enumerate(life["start"].values, start=1):
        look = {"transform": axis.get_xaxis_transform(), "weight": "bold", "ha": "center"}
        axis.text(start, 1.01, k, **look)


@style.styled
def changes(life: xr.Dataset, truth: xr.DataArray | None = None) -> Figure:
    """Draw the change of every parameter since new: median and 90 % band over the operations.

    ``truth`` has the true changes of a simulated life, ``(operation, parameter)``, percent.
    """
    if life["changed"].isnull().all():
        code = "operations-disagree" if life.attrs["agreement"] < 1.0 else "outside-family"
        why = say(f"change-{'beyond-wear' if life.attrs['family'] else code}")
        return p.empty("Changes of the parameters are not reported", why)
    names = [str(name) for name in life["parameter"].values]
    figure, axes = p.panels(len(names), columns=2, width=6.4, height=2.3, sharex=True)
    for axis, name in zip(axes, names, strict=True):
        _change(axis, life.sel(parameter=name), name, truth)
        p.change_lines(axis, life)
    axes[0].margins(x=0.01)
    axes[0].xaxis.set_major_formatter("{x:,.0f}")
    p.label_outer(axes, "operation", "% since new")
    low, middle, high = life["changed"].isel(asked=-1).transpose("quantile", ...).values
    sure = [k for k in np.argsort(-np.abs(middle)) if low[k] * high[k] > 0.0]
    moved = [f"{p.word(names[k])} {p.signed(in_digits(middle[k], 2, sign=True))} %" for k in sure]
    finding = f"Since new: {first_of(moved, 4) or 'no parameter has changed for sure'}"
    style.title(figure, finding, "changes of the parameters, percent since new")
    p.legend_below(figure, columns=4)
    return figure


def _change(axis: Axes, one: xr.Dataset, name: str, truth: xr.DataArray | None) -> None:
    """Draw band, median and truth of a parameter, and fit the axis to them."""
    color = p.OUTPUTS[name].colour
    low, middle, high = one["changed"].transpose("quantile", "asked").values
    look = {"color": color, "alpha": 0.3, "lw": 0, "label": "90 % interval"}
    axis.fill_between(one["asked"].values, low, high, **look)
    axis.plot(one["asked"], middle, color=color, lw=1.6, label="median")
    drawn = [low, high]
    if truth is not None:
        values = truth.sel(parameter=name)
        look = {"marker": "o", "ls": "", "mfc": "none", "ms": 4.5, "mew": 0.8, "label": "truth"}
        look["markevery"] = max(1, values.sizes["operation"] // 24)
        axis.plot(values["operation"], values, color=style.MEASURED, **look)
        drawn.append(values.values)
    least, most = (f(np.append(np.concatenate(drawn), 0.0)) for f in (np.nanmin, np.nanmax))
    room = 0.08 * (most - least) + 0.5
    axis.set_ylim(least - room, most + room)
    axis.set_title(p.named(name), loc="left")
    unchanged = one["unchanged"].values[-1]
    if np.isfinite(unchanged):
        axis.set_title(f"no change: {in_percent(unchanged)} probable", loc="right", fontsize=9)
