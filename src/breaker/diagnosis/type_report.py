"""The document of a fitted prior, and its lines of configuration."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import yaml

from breaker.common.document import Document, Remark, Section, Table, text_of
from breaker.common.numerals import in_digits
from breaker.common.wording import Sentence
from breaker.diagnosis.type_prior import DEVIATES, WIDEST, TypePrior
from breaker.diagnosis.words import say
from breaker.model.parameters import NAMES, PARAMETERS

_SWINGING = 0.2  # share of openings that swing back, from which the workflow rejects too many
_PRESSED = 0.9  # share of drives that press their contact: the default prior has more


def document_of(fitted: TypePrior, seed: int) -> Document:
    """Return what was fitted to which records, and what to look at."""
    size, noise = fitted.size, in_digits(fitted.sensor().noise_sd, 3)
    about = {"lengths": size.lengths, "times": size.times, "noise": noise}
    about |= {"breakers": ", ".join(fitted.names), "records": len(fitted.records)}
    remarks = [Remark(sentence, "WARNING: ") for sentence in warnings_of(fitted, seed)]
    parts: list = [Section(parts=remarks), _parameters(fitted)]
    if fitted.rejected:
        title = say("type-rejected", count=len(fitted.rejected))
        parts.append(Section(title, [Remark(reason) for reason in fitted.rejected]))
    return Document(summary=[say("type-source", **about)], parts=parts)


def warnings_of(fitted: TypePrior, seed: int) -> list[Sentence]:
    """Return warnings about breakers, and about drives of the prior that cannot be simulated."""
    learned = fitted.learned
    said = [say("type-one-breaker")] if len(fitted.names) == 1 else []
    for name, estimates in fitted.estimates.items():
        if name not in fitted.names:
            said.append(say("type-left-out", breaker=name, reason=estimates[0].why_not_inferred))
        elif outside := sum(e.misfit for e in estimates):
            said.append(say("type-outside", breaker=name, count=outside, records=len(estimates)))
    for name, evidence, off in zip(fitted.names, learned.evidence, learned.off, strict=True):
        k = int(evidence.argmax())
        if evidence[k] >= DEVIATES:
            about = {"parameter": NAMES[k], "off": 100.0 * off[k], "evidence": evidence[k]}
            said.append(say("type-deviates", breaker=name, **about))
    if wide := [NAMES[k] for k in np.flatnonzero(fitted.prior.log_sds == WIDEST)]:
        said.append(say("type-wide", parameters=", ".join(wide), widest=WIDEST))
    pressed = float(np.exp(fitted.prior.log_support))
    if pressed < _PRESSED:
        said.append(say("type-hardly-pressed", share=100.0 * pressed))
    swinging = fitted.swinging(seed) if "opening" in fitted.motions else 0.0
    if swinging > _SWINGING:
        said.append(say("type-swings", share=100.0 * swinging))
    return said


def _parameters(fitted: TypePrior) -> Table:
    """Medians and log-sds next to those of the family at this size, and the parts of log-sds."""
    prior, reference, learned = fitted.prior, fitted.reference, fitted.learned
    parts = np.array([learned.spread, learned.known, learned.shared, fitted.wear])
    rows = [
        (
            f"{parameter.name} ({parameter.unit})",
            *(f"{v:.4g}" for v in (prior.medians[k], reference.medians[k])),
            *(f"{v:.3f}" for v in (reference.log_sds[k], prior.log_sds[k], *parts[:, k])),
        )
        for k, parameter in enumerate(PARAMETERS)
    ]
    head = ("parameter", "median", "default", "its log_sd", "log_sd")
    head += ("of drives", "of medians", "shared", "wear")
    return Table(head, rows)


def configuration_lines(settings: Mapping, document: Document) -> str:
    """Return settings as YAML below the document as comments."""
    first = replace(document, summary=[say("type-title"), *document.summary])
    comments = "\n".join(f"# {line}".rstrip() for line in text_of(first).splitlines())
    sections = []
    for section, values in settings.items():
        text = yaml.safe_dump({section: values}, default_flow_style=None, sort_keys=False)
        sections.append(text.strip())
    return "\n\n".join([comments, *sections]) + "\n"
