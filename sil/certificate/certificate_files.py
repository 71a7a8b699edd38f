# SPDX-License-Identifier: MIT
"""The certificate as files, each whole or not at all: page, JSON, pictures, FORM_DEPTH."""

import base64
import io
import json
from collections.abc import Sequence
from dataclasses import asdict
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from rich.console import Console

from sil.certificate import certificate_report, gain_picture, notes, picture, verdict
from sil.certificate.certificate import Case, Certificate, Leg
from sil.certificate.chain import Chain
from sil.certificate.gains import CURVE_K_X
from sil.common import files
from sil.report import run_report
from sil.scenario import hull_files

_PAGE = Template((Path(__file__).parent / "certificate.html").read_text(encoding="utf-8"))
_LAW = ("LAW_", "VES_", "THR_", "FORM_FRAME")


def check(folder: Path, also: Path | None) -> None:
    """Check that `write` can write to the paths, leaving no file; OSError names the path given."""
    files.check_folder(folder, folder)
    if also is not None:
        if also.is_dir():
            raise OSError(f"{also}: is a folder; name a file")
        files.check_folder(also.parent, also)


def write(certificate: Certificate, folder: Path, also: Path | None) -> None:
    """Write page, JSON and pictures into a folder, which is made; write the JSON also to `also`."""
    name, legs = certificate.scenario.name, certificate.legs
    pictures = {"decay.png": picture.decay(name, legs), "chain.png": gain_picture.gains(name, legs)}
    drawn: list[bytes] = []
    folder.mkdir(parents=True, exist_ok=True)
    for file, figure in pictures.items():
        if figure is None:
            (folder / file).unlink(missing_ok=True)
            continue
        png = io.BytesIO()
        figure.savefig(png, format="png")
        files.replace(folder / file, png.getvalue())
        drawn.append(png.getvalue())
    files.replace(folder / "certificate.html", page(certificate, drawn).encode())
    for suffix, content in parameter_files(certificate).items():
        path = folder / f"certificate.{suffix}"
        if content:
            files.replace(path, content.encode())
        else:
            path.unlink(missing_ok=True)
    text = (json.dumps(document(certificate), indent=2, allow_nan=False) + "\n").encode()
    files.replace(folder / "certificate.json", text)
    if also is not None:
        also.parent.mkdir(parents=True, exist_ok=True)
        files.replace(also, text)


def parameter_files(certificate: Certificate) -> dict[str, str]:
    """Files with FORM_DEPTH by suffix, for ground stations; empty if no depth is certified."""
    depth = certificate.depth
    if not depth:  # a FORM_DEPTH of 0 would mean that every depth is allowed
        return dict.fromkeys(("param", "params"), "")
    head = f"# FORM_DEPTH of {certificate.scenario.name}, by flotilla certify"
    return hull_files.of_values({"FORM_DEPTH": float(depth)}, [head])


def page(certificate: Certificate, pictures: Sequence[bytes]) -> str:
    """The certificate as one HTML page that needs no other file; `pictures` are PNG."""
    terminal = Console(record=True, width=110, file=io.StringIO(), force_terminal=True)
    certificate_report.tell(certificate, terminal)
    code = "<pre>{code}</pre>"
    return _PAGE.substitute(
        style=run_report.STYLE,
        scenario=escape(certificate.scenario.name),
        level="good" if verdict.holds(certificate) else "bad",
        verdict=escape(verdict.sentence(certificate)),
        pictures="\n".join(map(_picture, pictures)),
        tables=terminal.export_html(inline_styles=True, code_format=code),
    )


def _picture(png: bytes) -> str:
    data = base64.b64encode(png).decode()
    return f'<img alt="How fast small errors decay" src="data:image/png;base64,{data}">'


def document(certificate: Certificate) -> dict[str, Any]:
    """The content of certificate.json: SI, complex numbers as [real, imaginary], ∞ as null."""
    scenario = certificate.scenario
    said = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "certified": verdict.holds(certificate),
        "depth": certificate.depth,
        "verdict": verdict.sentence(certificate),
        "notes": notes.notes(certificate),
        "legs": [_leg(leg) for leg in certificate.legs],
        "search": None if certificate.search is None else asdict(certificate.search),
    }
    told: dict[str, Any] = files.plain(said)
    return told


def _leg(leg: Leg) -> dict[str, Any]:
    reference, any_T = leg.reference, leg.reference.kind == "turning"
    return {
        "from_s": leg.from_s,
        "kind": reference.kind,
        "omega_max_radps": reference.omega_max,
        "omega_dot_max_radps2": reference.omega_dot_max,
        "omega_bar": reference.omega_bar,
        "T_s": None if any_T else reference.T_s,
        "T": certificate_report.period(reference),
        "mu": None if any_T else reference.mu,
        "mu_per_T_radps2": reference.mu / reference.T_s if reference.T_s else 0.0,
        "persistently_exciting": reference.mu > 0.0,
        "cases": [_case(case) for case in leg.cases],
        "chain": _chain(leg),
    }


def _chain(leg: Leg) -> dict[str, Any] | str | None:
    chain = leg.chain
    if not isinstance(chain, Chain) or leg.margins is None:
        return chain if isinstance(chain, str) else None
    told = {"certified": chain.certified, "holds": chain.holds, "margins": asdict(leg.margins)}
    return {**asdict(chain), **told}


def _case(case: Case) -> dict[str, Any]:
    own = case.setup.parameters
    loop, need = case.sampled, case.thrust
    return {
        "boats": case.boats,
        "parameters": {name: x for name, x in own.items() if name.startswith(_LAW)},
        "small_gain": asdict(case.small_gain),
        "floquet": asdict(case.floquet),
        "sampled": {**asdict(loop), "outcome": loop.outcome, "holds": loop.holds},
        "thrust": {**asdict(need), "given": need.given},
        "decay_against_k_x": {
            "k_x": list(CURVE_K_X) if case.curve_sampled else [],
            "floquet": case.curve_floquet,
            "sampled": case.curve_sampled,
            "sampled_of_law": case.curve_of_law,
        },
    }
