# SPDX-License-Identifier: MIT
"""The folder of a campaign: its identity, its finished parts and, in the end, its tables.

`campaign.json` describes the campaign. While `parts/` exists the campaign is unfinished, and
continues where it was interrupted. Every file appears whole or not at all.
"""

import fcntl
import io
import json
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from sil.campaign.run_outcome import RunResult
from sil.campaign.work import ShareResult
from sil.common import files

_SAMPLES = ("error_m", "psi_rad")


class CampaignError(ValueError):
    """A folder cannot be used: it holds another campaign, is unfinished, in use, or damaged."""


@dataclass(frozen=True)
class Identity:
    """The identity of a campaign: it determines every row of the tables.

    `document` is the scenario's document with its overrides; `code` is the result of `work.code()`.
    """

    scenario: str
    document: Mapping[str, Any]
    parameters: Mapping[str, float]
    seed: int
    runs: int
    code: str


class Folder:
    """A campaign's folder."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._parts = path / "parts"

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Create and lock the folder; CampaignError if another command is at work in it."""
        self.path.mkdir(parents=True, exist_ok=True)
        with (self.path / ".lock").open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise CampaignError(f"another command is at work in {self.path}") from None
            yield

    def is_begun(self) -> bool:
        """Whether the folder has an unfinished campaign."""
        return self._parts.is_dir()

    def check(self, identity: Identity) -> None:
        """CampaignError if the folder has an unfinished campaign other than this one."""
        if not self.is_begun():
            return
        known = self._known()
        if differences := self._differing(known, identity):
            can = f"Finish that one first, by {known.get('command')}, or remove"
            if known.get("code") != identity.code:
                can = "This version cannot finish that one: remove"
            raise CampaignError(
                f"{self.path} holds an unfinished campaign that differs in "
                f"{'; '.join(differences)}. {can} the folder, or choose another --out"
            )

    def _other_finished(self, identity: Identity) -> str:
        """Differences of a finished campaign in the folder; empty if there are none."""
        try:
            known = self._known()
        except (CampaignError, OSError):
            return ""
        return "; ".join(self._differing(known, identity, besides=("code",)))

    @staticmethod
    def _differing(
        known: Mapping[str, Any], identity: Identity, besides: Sequence[str] = ()
    ) -> list[str]:
        now = json.loads(json.dumps(asdict(identity)))
        keys = [key for key in now if key not in besides]
        return [each for key in keys for each in _differences(key, known.get(key), now[key])]

    def _known(self) -> dict[str, Any]:
        """The content of campaign.json; CampaignError if it is damaged."""
        path = self.path / "campaign.json"
        try:
            return dict(json.loads(path.read_text(encoding="utf-8")))
        except (TypeError, ValueError) as error:
            can = "remove the folder, or choose another --out"
            raise CampaignError(f"{path} cannot be read: {error}; {can}") from None

    def begin(
        self, identity: Identity, command: str, say: Callable[[str], object] = print
    ) -> list[ShareResult]:
        """Begin the campaign, or continue it; return the results that already exist.

        Unreadable results are removed and reported to `say`.
        """
        self.check(identity)
        self.path.mkdir(parents=True, exist_ok=True)
        if not self.is_begun():
            if other := self._other_finished(identity):
                say(f"{self.path} held a finished campaign with {other}; this one replaces it")
            self.write_json(identity, {"command": command})
            self._parts.mkdir()
        results = []
        for path in sorted(self._parts.glob("*.npz")):
            try:
                results.append(_decoded(path.read_bytes()))
            except Exception as error:  # whatever is wrong with the part, its runs are sailed again
                say(f"{path} cannot be read, its runs are sailed again: {error}")
                path.unlink()
        return results

    def keep(self, result: ShareResult) -> None:
        """Keep the results of a batch in a file named after its first run."""
        _replace(self._parts / f"{result.runs[0].run:06d}.npz", _encoded(result))

    def write(self, name: str, content: bytes) -> None:
        """Write a file of the results."""
        _replace(self.path / name, content)

    def write_json(self, identity: Identity, more: Mapping[str, Any]) -> None:
        """Write campaign.json: the identity of the campaign, and `more`."""
        text = json.dumps(files.plain({**asdict(identity), **more}), indent=1, allow_nan=False)
        _replace(self.path / "campaign.json", f"{text}\n".encode())

    def finish(self) -> None:
        """Delete the parts once everything is written."""
        shutil.rmtree(self._parts)


def _replace(path: Path, content: bytes) -> None:
    try:
        files.replace(path, content)
    except OSError as error:
        # the error of a full disk does not name the file
        raise OSError(error.errno, error.strerror, str(path)) from None


def _differences(key: str, was: Any, now: Any) -> Iterator[str]:
    if isinstance(was, dict) and isinstance(now, dict):
        for name in sorted({*was, *now}):
            yield from _differences(f"{key}.{name}", was.get(name), now.get(name))
    elif was != now:
        yield "its code" if key == "code" else f"{key}: {json.dumps(was)}, now {json.dumps(now)}"


def _encoded(result: ShareResult) -> bytes:
    """A batch's results as an .npz file: JSON, which keeps every bit, except for the samples."""
    names = [field.name for field in fields(RunResult) if field.name not in _SAMPLES]
    runs = [{name: getattr(run, name) for name in names} for run in result.runs]
    sailed = [run for run in result.runs if run.boats]
    samples = {name: np.array([getattr(run, name) for run in sailed]) for name in _SAMPLES}
    buffer = io.BytesIO()
    about = np.array(json.dumps({"runs": runs, "busy_s": result.busy_s}))
    # numpy's stubs take any keyword for its own options
    np.savez(buffer, about=about, **samples)  # type: ignore[arg-type]
    return buffer.getvalue()


def _decoded(content: bytes) -> ShareResult:
    with np.load(io.BytesIO(content), allow_pickle=False) as part:
        about = json.loads(str(part["about"]))
        samples = iter(zip(*(part[name] for name in _SAMPLES), strict=True))
    runs = []
    for run in about["runs"]:
        run |= {name: tuple(run[name]) for name in ("boats", "states")}
        of_run = dict(zip(_SAMPLES, next(samples), strict=True)) if run["boats"] else {}
        runs.append(RunResult(**run, **of_run))
    return ShareResult(tuple(runs), about["busy_s"])
