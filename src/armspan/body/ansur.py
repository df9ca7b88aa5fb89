"""Body sizes of the 2012 US Army survey (ANSUR II) as one joint Gaussian, and what is left once some are known.

The population's means and second moments hold every linear regression of some sizes on others: conditioning
the Gaussian on exactly known sizes *is* ordinary least squares (Anderson 2003, An Introduction to
Multivariate Statistical Analysis, 2.5), whichever sizes a person happens to type.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from armspan.frames import Array

Size: TypeAlias = Literal[
    "stature",
    "man",
    "eye height",
    "eye over seat",
    "acromion height",
    "half breadth",
    "half pupils",
    "upper arm",
    "forearm",
    "hand",
    "forearm and hand",
    "span",
]
"""A size [m] of an erect, barefoot person; ``man`` is 1 for a man and 0 for a woman.

``half breadth`` is half the biacromial breadth, ``half pupils`` half the distance between the pupils. The arm
hangs: ``upper arm`` from the acromion to the radiale, ``forearm`` on to the stylion, ``hand`` on to the tip of
the middle finger; ``forearm and hand`` from the back of the bent elbow to that tip; ``span`` from tip to tip.
Standing eye height is stature less sitting height plus sitting eye height.
"""

SIZES: tuple[Size, ...] = get_args(Size)


@dataclass(frozen=True, slots=True, eq=False)
class Population:
    """The sizes of a population, or of the one person that is partly known.

    ``mean`` (12,) [m] and ``covariance`` (12, 12) [m²] in the order of `SIZES`.
    """

    mean: Array
    covariance: Array

    def given(self, known: Mapping[Size, tuple[float, float]]) -> "Population":
        """The same once ``known`` sizes are told as (value, standard deviation of the telling) [m]."""
        if not known:
            return self
        places = [SIZES.index(name) for name in known]
        value, sd = np.array(list(known.values())).T
        seen = self.covariance[np.ix_(places, places)] + np.diag(sd**2)
        gain = np.linalg.solve(seen, self.covariance[places]).T
        covariance = self.covariance - gain @ self.covariance[places]
        return Population(self.mean + gain @ (value - self.mean[places]), (covariance + covariance.T) / 2.0)


# 4082 men and 1986 women of 17 to 58 years, soldiers, in mm and mm² (for ``man``: 1 and mm); the second
# moments about the mean with the divisor n - 1, lower triangle. Own derivation from the public tables.
# fmt: off
_MEAN_MM = (
    1714.406, 0.6727093, 1602.213, 785.9145, 1406.161, 199.6021,
    31.6301, 327.3744, 259.1923, 189.2866, 467.0071, 1763.795,
)
_LOWER_MM2 = (
    (8102.761,),
    (28.12963, 0.2202078),
    (7786.498, 27.06437, 7551.463),
    (3231.341, 12.51362, 3122.325, 1752.745),
    (6978.931, 23.26313, 6731.168, 2692.41, 6255.394),
    (1051.451, 5.541166, 1010.668, 442.5651, 879.5401, 228.5677),
    (54.30456, 0.2541091, 52.46825, 15.31171, 48.46392, 10.57242, 3.332267),
    (1603.363, 5.295138, 1551.155, 556.8471, 1429.783, 210.5565, 12.69181, 429.3192),
    (1475.144, 5.847033, 1428.32, 477.3009, 1291.529, 214.2624, 14.98103, 329.7773, 391.1526),
    (788.2797, 2.685373, 763.5538, 269.1773, 689.963, 114.4179, 8.683147, 173.054, 175.2717, 132.3832),
    (2350.394, 8.885788, 2275.442, 785.5796, 2057.851, 340.7362, 23.96177, 523.5386, 557.9057, 309.786, 902.0904),
    (8967.988, 33.88289, 8705.76, 3178.202, 7770.401, 1353.809, 84.25858, 2059.497, 1998.743, 1075.52,
     3161.589, 12283.9),
)
# fmt: on


def _ansur() -> Population:
    lower = np.zeros((len(SIZES), len(SIZES)))
    lower[np.tril_indices(len(SIZES))] = [value for row in _LOWER_MM2 for value in row]
    unit = np.array([1.0 if name == "man" else 1e-3 for name in SIZES])
    covariance = lower + np.tril(lower, -1).T
    return Population(unit * _MEAN_MM, covariance * np.outer(unit, unit))


ANSUR: Population = _ansur()
"""ANSUR II: 2012 Anthropometric Survey of U.S. Army Personnel (Natick/TR-15/007), adults, erect and barefoot."""
