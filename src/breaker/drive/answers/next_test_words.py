"""Which test to do next, in words."""

from collections.abc import Iterator

from breaker.common.numerals import in_digits
from breaker.documents.parts import Document, Remark, Section, Table
from breaker.drive.answers.next_test import Outlook, Plan, Plans

_ROW = "  {:<17} {:>6} {:>9} {:>9}  {}"
_HEAD = ("test", "cost", "narrows", "per cost", "standard deviations, now and expected")
_LITTLE = 0.05  # of the variance, below which a narrowing is not worth a word
_SHOWN = 4  # quantities of a test


def words_of_plans(plans: Plans) -> Document:
    """Return the tests of each pole in words: what to do first, and a table of all."""
    parts = [_section(each) for each in plans.poles]
    said = [f"rejected: {why}" for why in plans.rejected.values()]
    return Document(summary=said, parts=parts)


def first_of_plan(plan: Plan) -> str:
    """Return in words what to do first, or why nothing is foretold."""
    if plan.reason:
        return f"nothing is foretold: {plan.reason}"
    if not plan.tests or plan.tests[0].gain < _LITTLE:
        return "none of the tests would narrow what is asked for by more than a twentieth"
    first = plan.tests[0]
    some = ", ".join(_narrowed(first, plan))
    return (
        f"first: {first.what}. It takes away {100.0 * first.gain:.0f} % of the variance for a cost "
        f"of {first.cost:g}: {some}"
    )


def _section(plan: Plan) -> Section:
    of = " and ".join(f"{n} {motion}{'s' * (n > 1)}" for motion, n in plan.records.items())
    about = ", ".join(filter(None, (plan.breaker, plan.phase)))
    title = f"next test after {of or 'these records'}{' of ' * bool(about)}{about}"
    parts = [Remark(first_of_plan(plan))]
    if plan.tests:
        rows = [_row(each, plan) for each in plan.tests]
        notes = [
            f"narrows: mean share of the variance of {', '.join(plan.asked)} that goes; per cost: "
            "that over the cost. Sds are of the posterior, of parameters in percent.",
            *_widening(plan),
            *_adds(plan),
        ]
        parts.append(Table(_HEAD, rows, notes=notes, form=_ROW))
    return Section(title, parts)


def _row(outlook: Outlook, plan: Plan) -> tuple[str, ...]:
    share = "" if outlook.reason else f"{100.0 * outlook.gain:.0f} %"
    each = "" if outlook.reason else f"{100.0 * outlook.per_cost:.1f} %"
    said = outlook.reason or "; ".join(_narrowed(outlook, plan)) or "hardly anything"
    return outlook.name, f"{outlook.cost:g}", share, each, said


def _narrowed(outlook: Outlook, plan: Plan) -> Iterator[str]:
    """What a test would narrow most of all that is asked for."""
    told = {name: outlook.narrowing[name] for name in plan.asked if name in outlook.narrowing}
    most = sorted(told, key=lambda name: -told[name].gone)[:_SHOWN]
    for name in most:
        each = told[name]
        if each.gone > _LITTLE:
            now, then = (in_digits(value, 2) for value in (each.now, each.expected))
            yield f"{name} {now} to {then}{'' if each.unit == '1' else f' {each.unit}'}"


def _widening(plan: Plan) -> Iterator[str]:
    """Which tests would widen what is known, as no test does on average."""
    if wider := [each.name for each in plan.tests if each.gain < -_LITTLE]:
        yield (
            f"on average no test widens what is known: that {' and '.join(wider)} would is an "
            "error of the networks, which tell few records too narrowly or many of them too widely"
        )


def _adds(plan: Plan) -> Iterator[str]:
    """What is not known without a test at all."""
    for each in plan.tests:
        if each.adds:
            told = ", ".join(f"{name} {in_digits(sd, 2)} %" for name, sd in each.adds.items())
            yield f"{each.name} tells what is unknown without it, with sds of: {told}"
