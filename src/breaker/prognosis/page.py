"""The first page, in sentences and as HTML: rendered from tables, never read back."""

import math
from collections.abc import Mapping, Sequence

import pandas as pd
import xarray as xr

from breaker.common.document import Document, Table
from breaker.common.numerals import first_of, in_digits, in_p
from breaker.configuration.definitions import advice_on
from breaker.diagnosis.words import say
from breaker.model.parameters import PARAMETERS

_NOTED = 2.0  # percent, beyond which a change is worth a word
_SURE = 0.05  # probability of no change below which a parameter is named
_MOST = 4
_PERHAPS = 2
_WORDS = {each.name: each.word for each in PARAMETERS}


def since_new(changes: pd.DataFrame, life: xr.Dataset) -> str:
    """Say what has changed since new, and what may have.

    Args:
        changes: What ``change_table`` returns; its last row counts.
        life: What ``life.forecast_of`` returns.
    """
    row = changes.iloc[-1]
    if not life.attrs["family"]:
        return "Since new: parameters are withheld, see trust; what is measured holds."
    if row.noticed < life.attrs["reported_from"]:
        records = f"{life.attrs['needed']:,}, and there are {life.sizes['operation']:,}"
        return f"Since new: nothing is told before record {records}."
    names = [str(name) for name in life.parameter.values]
    if math.isnan(row[names[0]]):
        return f"Since new: {say('change-beyond-wear')}."
    sure = [name for name in names if row[f"{name}_unchanged"] < _SURE]
    sure.sort(key=lambda name: -abs(row[name]))
    told = [f"{_WORDS[name]} {_signed(row[name])} % ({_span(row, name)})" for name in sure]
    rest = [name for name in names if name not in sure]
    most = {name: max(abs(row[f"{name}_5"]), abs(row[f"{name}_95"])) for name in rest}
    may = sorted((name for name in rest if most[name] > _NOTED), key=lambda name: -most[name])
    words = ", ".join(told) if told else "nothing for sure"
    if may:
        perhaps = first_of([_WORDS[name] for name in may], _PERHAPS)
        words += f"; perhaps {perhaps}, by up to {in_digits(most[may[0]], 2)} %"
    if len(may) < len(rest):
        words += f"; nothing else beyond {_NOTED:g} %"
    return f"Since new: {words}."


def _span(row: pd.Series, name: str) -> str:
    return f"{_signed(row[f'{name}_5'])} to {_signed(row[f'{name}_95'])}"


def _signed(value: float) -> str:
    return in_digits(value, 2, sign=True)


def headline(decisions: pd.DataFrame, limits: pd.DataFrame) -> str:
    """Say what to do after the last operation, and why, by the tables of decisions and limits."""
    row = decisions.iloc[-1]
    by_limit = limits.drop_duplicates("limit")
    unknown = by_limit[by_limit.state == "unknown"]
    ends = span(row.operations_left_5, row.operations_left_95)
    left = f"{about(row.operations_left)} operations left ({ends})"
    if row.state == "due":
        over = by_limit[by_limit.certain.notna()].sort_values("certain")
        each = [f"{one.limit} (certain at {one.certain:,})" for one in over.itertuples()]
        why = f"exceeded: {first_of(each, _MOST)}" if each else f"{row.limit} is due, {left}"
        words = f"Service now: {why}"
    elif row.state == "planned":
        on = f" ({row.service_by_date})" if row.get("service_by_date") else ""
        words = f"Plan service by operation {row.service_by:,}{on}: {row.limit}, {left}"
    elif row.state == "ok":
        known = row.limit and math.isfinite(row.operations_left)
        words = f"OK: next is {row.limit}, {left}" if known else "OK: nothing leads to a limit"
    else:
        words = "Unknown: no limit can be told yet"
    cannot = [
        f"{one.limit} (P {in_percent(one.p_exceeded)})"
        for one in unknown.itertuples()
        if one.p_exceeded == one.p_exceeded
    ]
    doubts = f" Cannot tell {first_of(cannot, _MOST)}." if cannot and row.state != "unknown" else ""
    if row.state in ("planned", "due"):
        words += f". Recommended since operation {row.recommended_since:,}"
    if row.state == "planned" and row.risk == row.risk:
        words += f"; P {in_percent(row.risk)} to fail before the next inspection"
    return f"{words}.{doubts} As of operation {row.operation:,}."


def look_first(
    decisions: pd.DataFrame, limits: pd.DataFrame, advice: Mapping[str, str]
) -> list[str]:
    """Say where to look first for the limits that are due or planned, the one due first first."""
    due = limits[limits.state.isin(["planned", "due"])]
    first = due.limit == decisions.iloc[-1].limit
    names = dict.fromkeys([*due.quantity[first], *due.quantity[~first]])
    look = say("look-first")
    return [f"{look}: {'; '.join(said)}." for said in [advice_on(names, advice)] if said]


def trust(life: xr.Dataset) -> str:
    """Say how far the answer can be trusted."""
    least = in_p(float(life.p_value.min())) if life.sizes["motion"] else "p unknown"
    if not life.attrs["family"]:
        agree = life.attrs["agreement"]
        why = f"{say('change-operations-disagree')} on what has changed ({in_p(agree)})"
        why = why if agree < 1.0 else f"{say('change-outside-family')} ({least})"
        return f"Trust: {why}; only what is measured is told."
    words = f"Trust: drives of the family {life.attrs['family']} look like this one ({least})"
    if life.sizes["motion"] > 1:
        words += f", and closing and opening agree ({in_p(life.attrs['agreement'])})"
    return f"{words}."


def limit_words(limits: pd.DataFrame) -> pd.DataFrame:
    """Return the table of limits of the first page, in words."""
    rows = []
    for one in limits.itertuples():
        if one.certain is not pd.NA and one.certain == one.certain:
            left = exceeded(one.certain, one.crossed)
        elif math.isnan(one.operations_left) or one.state == "unknown":
            left = "cannot be told"
        else:
            ends = span(one.operations_left_5, one.operations_left_95)
            left = f"{about(one.operations_left)} ({ends})"
        rows.append(
            {
                "limit": one.limit,
                "state": one.state,
                "quantity": f"{'change of ' if one.of == 'change' else ''}{one.quantity}",
                "new": in_digits(one.new, 4),
                "now (90 %)": "{} ({} to {})".format(
                    *(in_digits(each, 4) for each in (one.now, one.now_5, one.now_95))
                ),
                "at": f"{in_digits(one.bound, 4)} {one.unit}",
                "P": in_percent(one.p_exceeded) if one.p_exceeded == one.p_exceeded else "",
                "operations left (90 %)": left,
            }
        )
    return pd.DataFrame(rows)


def opening(sentences: Sequence[str], limits: pd.DataFrame, picture: bytes) -> str:
    """Return sentences, a table and a picture as one element of HTML, which loads nothing.

    Args:
        sentences: The first is the headline.
        limits: What ``limit_words`` returns.
        picture: The figure of the verdict, PNG.
    """
    # Imported here, as figures take words from this module, and need no jinja2.
    from breaker.common.document import html_page

    first, *others = sentences
    table = Table([*limits], limits.astype(str).values.tolist())
    page = Document(first, summary=others, parts=[table])
    return html_page(page, [picture], alt="How each limit stands", inner="first-page")


def exceeded(certain: float, crossed: float) -> str:
    """Say since when a limit is exceeded."""
    return f"exceeded: certain at {certain:,.0f}, crossed about {crossed:,.0f}"


def about(value: float) -> str:
    """Write a number of operations or days that is an estimate, to three digits.

    >>> about(1878.3), about(42.4), about(float("inf"))
    ('1,880', '42', 'beyond the horizon')
    """
    if not math.isfinite(value):
        return "unknown" if math.isnan(value) else "beyond the horizon"
    digits = max(0, math.floor(math.log10(max(value, 1.0))) - 2)
    return f"{round(value, -digits):,.0f}"


def span(low: float, high: float) -> str:
    """Write an interval of such numbers."""
    return f"{about(low)} to {about(high)}"


def in_percent(probability: float) -> str:
    """Write a probability; never 0 or 100 % of what is not certain.

    >>> in_percent(0.233), in_percent(0.9996), in_percent(0.001)
    ('23 %', '> 99 %', '< 1 %')
    """
    if probability < 0.01:
        return "< 1 %"
    return "> 99 %" if probability > 0.99 else f"{100 * probability:.0f} %"
