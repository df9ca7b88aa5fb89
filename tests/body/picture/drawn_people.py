"""A person drawn with lines and discs, facing us with the arms out: photographs of people stay out of a repository."""

from itertools import pairwise

import numpy as np

SKIN, SHIRT, TROUSERS, SHOES, HAIR = (224, 172, 140), (40, 90, 160), (40, 40, 60), (25, 25, 25), (60, 40, 25)
WHITE, PUPIL, LIPS = (250, 250, 250), (40, 30, 30), (170, 60, 60)

SIDE = {"sh": (0.105, 0.19), "el": (0.26, 0.20), "wr": (0.40, 0.20), "eye": (0.017, 0.064), "hip": (0.05, 0.49)}
SIDE |= {"kn": (0.06, 0.72), "an": (0.06, 0.94)}
"""Places on the left half of the body: to the side and down from the top, over the body's height."""


def wall_and_floor(width: int = 640, height: int = 640) -> np.ndarray:
    """A picture of nobody."""
    image = np.full((height, width, 3), (196, 206, 190), np.uint8)
    image[int(height * 0.8) :] = (150, 120, 95)
    return image


class Pencil:
    """Draws into a picture in heights of a body whose top is at (``middle``, ``top``) [px]."""

    def __init__(self, image: np.ndarray, middle: int, top: int, tall: int) -> None:
        self.image, self.middle, self.top, self.tall = image, middle, top, tall

    def at(self, place):
        return round(self.middle + place[0] * self.tall), round(self.top + place[1] * self.tall)

    def line(self, colour, wide, *places):
        import cv2

        for one, other in pairwise(places):
            cv2.line(self.image, self.at(one), self.at(other), colour, max(1, round(wide * self.tall)), cv2.LINE_AA)

    def disc(self, colour, place, wide, high):
        import cv2

        axes = (round(wide * self.tall), round(high * self.tall))
        cv2.ellipse(self.image, self.at(place), axes, 0, 0, 360, colour, -1, cv2.LINE_AA)

    def shape(self, colour, *places):
        import cv2

        cv2.fillPoly(self.image, [np.array([self.at(place) for place in places])], colour, cv2.LINE_AA)


def drawn_person(image: np.ndarray, middle: int, top: int = 120, tall: int = 420) -> dict[str, tuple[int, int]]:
    """Draw a person ``tall`` pixels high into the picture: where the joints are, by a skeleton's names."""
    pencil = Pencil(image, middle, top, tall)
    for sign in (-1, 1):
        limbs(pencil, sign)
    pencil.shape(SHIRT, (-0.125, 0.165), (0.125, 0.165), (0.09, 0.35), (0.095, 0.5), (-0.095, 0.5), (-0.09, 0.35))
    face(pencil)
    sides = {
        side + name: pencil.at((sign * x, y)) for side, sign in (("r", -1), ("l", 1)) for name, (x, y) in SIDE.items()
    }
    return sides | {"nose": pencil.at((0, 0.082))}


def limbs(pencil: Pencil, sign: int) -> None:
    sh, el, wr, hip, kn, an = ((sign * SIDE[name][0], SIDE[name][1]) for name in ("sh", "el", "wr", "hip", "kn", "an"))
    pencil.line(TROUSERS, 0.085, hip, kn)
    pencil.line(TROUSERS, 0.06, kn, an)
    pencil.line(SHOES, 0.045, an, (sign * 0.07, 0.985))
    pencil.line(SHIRT, 0.06, sh, (sign * 0.2, 0.197))
    pencil.line(SKIN, 0.045, (sign * 0.2, 0.197), el, wr, (sign * 0.44, 0.2))
    for spread, reach in ((-0.016, 0.461), (-0.005, 0.505), (0.006, 0.461), (0.016, 0.42)):
        pencil.line(SKIN, 0.01, (sign * 0.445, 0.2 + spread), (sign * reach, 0.2 + 1.3 * spread))
    pencil.line(SKIN, 0.012, (sign * 0.42, 0.19), (sign * 0.45, 0.165))


def face(pencil: Pencil) -> None:
    pencil.line(SKIN, 0.055, (0, 0.1), (0, 0.16))
    pencil.disc(HAIR, (0, 0.05), 0.047, 0.058)
    pencil.disc(SKIN, (0, 0.068), 0.041, 0.056)
    for sign in (-1, 1):
        pencil.disc(WHITE, (sign * 0.017, 0.064), 0.009, 0.005)
        pencil.disc(PUPIL, (sign * 0.017, 0.064), 0.004, 0.005)
        pencil.line(HAIR, 0.005, (sign * 0.008, 0.053), (sign * 0.026, 0.053))
        pencil.disc(SKIN, (sign * 0.043, 0.072), 0.008, 0.014)
    pencil.line((190, 135, 110), 0.006, (0, 0.066), (0.003, 0.083))
    pencil.line(LIPS, 0.006, (-0.014, 0.1), (0.014, 0.1))
