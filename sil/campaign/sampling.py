# SPDX-License-Identifier: MIT
"""The runs of a campaign: one scenario, each run with its own draws of what `[[vary]]` names.

Every number has a generator of its own, seeded by the campaign's seed, the run and the key: a run
does not depend on how many there are, nor a key's draw on which other keys are drawn.
"""

import copy
from dataclasses import replace
from zlib import crc32

import numpy as np

from sil import scenario
from sil.campaign.varied import Value, Varied, array_of, at, complete_document, varied
from sil.scenario import Scenario, ScenarioError
from sil.toml_errors import KeyPath, Source, lay

Draws = dict[str, Value]
"""What a run's varied keys come to, by their dotted names: `boat.2.eta.3`."""


class Sampler:
    """Makes scenarios of a document: `scenario(run)` is run `run` of the campaign with `seed`.

    Without a seed it is the document's.

    ScenarioError where a `[[vary]]` cannot be; it names file, line and key.
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
                    # an array must be whole before a draw takes the place of one element
                    inside = array_of(one.path, complete)
                    own = at(complete, inside)
                    lay(document, inside, list(own) if isinstance(own, tuple) else own)
            except LookupError as error:
                raise source.error(place, f'"vary.key" = "{vary.key}": {error.args[0]}') from None
        self._source = replace(source, document=document, drawn=drawn)

    @property
    def parameters(self) -> set[str]:
        """Names of the firmware's parameters that are drawn, of some boat or of all."""
        return {path[-1] for path in self._varied if path[-2:-1] == ("parameters",)}

    def seed_of(self, run: int) -> int:
        """The scenario's seed in run `run`."""
        return int(self._generator(run, "seed").integers(2**53))

    def draws(self, run: int) -> Draws:
        """What the varied keys are in run `run`."""
        return {one.name: one.draw(self._generator(run, one.name)) for one in self._varied.values()}

    def scenario(self, run: int) -> Scenario:
        """The scenario of run `run`; ScenarioError, which names the run, where it cannot be."""
        document = copy.deepcopy(self._source.document)
        document["seed"] = self.seed_of(run)
        for path, one in self._varied.items():
            lay(document, path, one.draw(self._generator(run, one.name)))
        try:
            return scenario.check(replace(self._source, document=document))
        except ScenarioError as error:
            raise ScenarioError(f"run {run}: {error}") from None

    def _generator(self, run: int, key: str) -> np.random.Generator:
        spawn_key = (run, crc32(key.encode()))
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=spawn_key))
