# SPDX-License-Identifier: MIT
"""The search for gains as rows of a table, beside today's gains and their effects."""

from collections.abc import Iterable

from sil.certificate.certificate import Certificate
from sil.certificate.notes import listed
from sil.certificate.search import Search

_NOTHING = 1e-4  # 1/s: smaller rates are neither decay nor growth


def search_rows(certificate: Certificate, search: Search) -> Iterable[tuple[str, str]]:
    """Rows of two texts: a name, and a value."""
    if search.decay_of_law < _NOTHING:
        yield "none", "with all gains tried, some error does not decay"
        return
    for name, gain in search.gains.items():
        yield name, f"{gain:.3g} (now {_now(certificate, name)}; {_span(search, name)})"
    off, off_now = search.decay_of_law, search.decay_of_law_now
    yield "decay of the slowest boat (1/s)", ""
    yield "  LAW_OBS_BW = LAW_CUR_BW = 0", f"{off:.4f} (now {off_now:z.4f})"
    if min(search.decay - off, search.decay_now - off_now) < -_NOTHING:
        yield "  with their present values", f"{search.decay:z.4f} (now {search.decay_now:z.4f})"
    yield "thrust from the fixes' noise", "factor relative to now"
    for source, ratio in search.noise.items():
        yield f"  in {source}", f"{ratio:.2g}"
    ended = "" if search.complete else ", up to the limit of cycles"
    yield "searched", f"{search.evaluations} points{ended}; small errors, no noise, no limits"


def _span(search: Search, name: str) -> str:
    low, high = search.ranges[name]
    where = "at the end of" if name in search.at_end else "searched"
    return f"{where} {low:g} … {high:g}"


def _now(certificate: Certificate, name: str) -> str:
    """The present values of a gain, of all boats behind a leader that moves."""
    legs = [leg for leg in certificate.legs if leg.reference.kind != "rest"]
    return listed(sorted({case.setup.parameters[name] for leg in legs for case in leg.cases}))
