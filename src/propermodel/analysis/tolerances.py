"""How much an output may change: a tolerance for one or more features of its error."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

from propermodel.analysis.comparison import Feature, OutputError
from propermodel.analysis.features import Undefined
from propermodel.diagnostics import ReductionError


@dataclass(frozen=True, kw_only=True, slots=True)
class Tolerance:
    """How much an output may differ from that of the full model; at least one of the features is given.

    The features of the values are shares of the range of the full model's output: the mean of the absolute difference
    over time, its root mean square, its largest value, the difference at the end (natural for what is summed up along a
    run, as fuel is), and that of the peaks. Those of times are shares of the full model's time: until the peak, of the
    rise, until it has settled; `propermodel.analysis.features` defines them.
    """

    mean: float | None = None
    rms: float | None = None
    largest: float | None = None
    final: float | None = None
    peak: float | None = None
    peak_time: float | None = None
    rise: float | None = None
    settling: float | None = None

    def __post_init__(self) -> None:
        if not self.shares or not all(0.0 < share < math.inf for share in self.shares.values()):
            raise ReductionError.of(
                "reduction/tolerance",
                "a tolerance needs a feature of the error, with a share above zero",
                help="for 1 % of the range at the end of the run: Tolerance(final=0.01); "
                f"features are {', '.join(feature.value for feature in Feature)}",
            )

    @classmethod
    def of(cls, given: float | Tolerance) -> Tolerance:
        """A tolerance; a number is the root mean square."""
        return given if isinstance(given, Tolerance) else cls(rms=float(given))

    @property
    def shares(self) -> Mapping[Feature, float]:
        """What is given, by feature."""
        given = ((Feature(field.name), getattr(self, field.name)) for field in dataclasses.fields(self))
        return {feature: float(share) for feature, share in given if share is not None}

    @property
    def smallest(self) -> float:
        """The smallest share: what predictions, which know root mean squares alone, are judged by."""
        return min(self.shares.values())

    def score(self, error: OutputError) -> float:
        """The largest error over its tolerance; infinite where the output has lost a feature."""
        return max(self.scores(error).values())

    def scores(self, error: OutputError) -> Mapping[Feature, float]:
        """Every error over its tolerance, by feature."""
        found = {feature: error.of(feature) for feature in self.shares}
        return {
            feature: math.inf if isinstance(value, Undefined) else value / self.shares[feature]
            for feature, value in found.items()
        }

    def __str__(self) -> str:
        return ", ".join(f"{feature.value} within {100.0 * share:.3g} %" for feature, share in self.shares.items())
