# SPDX-License-Identifier: MIT
"""The runs of a campaign: one scenario, in which each run draws the keys of `[[vary]]` anew.

Every number has its own generator, seeded by the campaign's seed, the run and the key. Thus a run
does not depend on the number of runs, nor a key's draw on the other keys. A start at which two
boats are nearer than `start_apart_m` is rejected and drawn again as a whole: accepted starts have
the density of the file, restricted to the allowed starts.
"""

import copy
import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from zlib import crc32

import numpy as np

from sil.campaign.varied import Value, Varied, array_of, at, complete_document, varied
from sil.scenario import scenario
from sil.scenario.scenario import Scenario, ScenarioError
from sil.scenario.toml_errors import KeyPath, Source, lay

Draws = dict[str, Value]
"""The drawn values of a run's varied keys, by their dotted names: `boat.2.eta.3`."""


_ATTEMPTS = 1000


class Sampler:
    """Makes the scenarios of a campaign: `scenario(run)` is run `run` of the campaign with `seed`.

    By default the seed is the document's.

    ScenarioError if a `[[vary]]` is invalid; it names file, line and key.
    """

    def __init__(self, source: Source, seed: int | None = None) -> None:
        self.nominal = scenario.check(source)
        self.seed = self.nominal.seed if seed is None else seed
        if self.seed < 0:
            raise ScenarioError(f"seed {self.seed}: must be greater than or equal to 0")
        complete = complete_document(self.nominal)
        self._varied: dict[KeyPath, Varied] = {}
        document = copy.deepcopy(source.document)
        document.pop("vary", None)
        drawn: dict[KeyPath, KeyPath] = {}
        of_boats: dict[KeyPath, bool] = {}
        for number, vary in enumerate(self.nominal.vary, start=1):
            place = ("vary", str(number), "key")
            try:
                for one in varied(vary, self.nominal, complete):
                    if one.path in self._varied:
                        raise LookupError(f'"{one.name}" is varied twice')
                    of_boat = one.path[0] == "boat"
                    inner = one.path[2:] if of_boat else one.path
                    if of_boats.setdefault(inner, of_boat) != of_boat:
                        raise LookupError(f'"{one.name}": varied of all boats and of one')
                    self._varied[one.path] = one
                    drawn[one.path] = place
                    # an array must exist before a draw replaces one of its elements
                    inside = array_of(one.path, complete)
                    own = at(complete, inside)
                    lay(document, inside, list(own) if isinstance(own, tuple) else own)
            except LookupError as error:
                raise source.error(place, f'"vary.key" = "{vary.key}": {error.args[0]}') from None
        self._source = replace(source, document=document, drawn=drawn)

    @property
    def parameters(self) -> set[str]:
        """Names of the firmware parameters that are drawn for some or all boats."""
        return {path[-1] for path in self._varied if path[-2:-1] == ("parameters",)}

    def seed_of(self, run: int) -> int:
        """The scenario's seed in run `run`."""
        return int(self._generator(run, "seed").integers(2**53))

    def draws(self, run: int) -> Draws:
        """The drawn values of run `run`; ScenarioError if all drawn starts were too close."""
        return {".".join(path): value for path, value in self._drawn(run).items()}

    def scenario(self, run: int) -> Scenario:
        """The scenario of run `run`; ScenarioError, which names the run, if it is invalid."""
        document = copy.deepcopy(self._source.document)
        document["seed"] = self.seed_of(run)
        for path, value in self._drawn(run).items():
            lay(document, path, value)
        try:
            return scenario.check(replace(self._source, document=document))
        except ScenarioError as error:
            raise ScenarioError(f"run {run}: {error}") from None

    def _drawn(self, run: int) -> dict[KeyPath, Value]:
        for attempt in range(_ATTEMPTS):
            drawn = {
                path: one.draw(self._generator(run, one.name, attempt))
                for path, one in self._varied.items()
            }
            if self._wide_enough(drawn):
                return drawn
        least_m = self.nominal.start_apart_m
        raise ScenarioError(
            f"run {run}: no start in {_ATTEMPTS} draws is {least_m} m apart; "
            "vary the starts more, or lower start_apart_m"
        )

    def _wide_enough(self, drawn: Mapping[KeyPath, Value]) -> bool:
        """Whether boats start as far apart as the scenario demands."""
        places = []
        for number, boat in enumerate(self.nominal.boat, start=1):
            own = [drawn.get(("boat", str(number), "eta", str(i + 1)), boat.eta[i]) for i in (0, 1)]
            places.append([float(value) for value in own])
        least_m = self.nominal.start_apart_m
        return all(math.dist(a, b) >= least_m for a, b in combinations(places, 2))

    def _generator(self, run: int, key: str, attempt: int = 0) -> np.random.Generator:
        spawn_key = (run, crc32(key.encode()), *([attempt] if attempt else []))
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=spawn_key))
