"""What a person types: plausible people pass, everything else is answered in one sentence."""

import math

import msgspec
import pytest

from armspan.body.told import Told
from armspan.errors import ConfigError


def complaint(**typed: object) -> str:
    with pytest.raises(ConfigError) as caught:
        Told(**({"height_m": 1.75} | typed))  # type: ignore[arg-type]
    return str(caught.value)


@pytest.mark.parametrize(
    ("typed", "parts"),
    [
        ({"height_m": 1750}, ["height_m = 1750", "1.2 and 2.3", "millimetres", "did you mean 1.75?"]),
        ({"height_m": 175}, ["height_m = 175", "centimetres", "did you mean 1.75?"]),
        # 5.9 ft = 1.79832 m; 5 ft 9 in = 69 in = 1.7526 m
        ({"height_m": 5.9}, ["height_m = 5.9", "feet", "did you mean 1.798 (5.9 feet) or 1.753 (5 feet 9 inches)?"]),
        ({"height_m": 6}, ["feet", "did you mean 1.829?"]),
        ({"height_m": 69}, ["inches", "did you mean 1.753?"]),
        ({"height_m": 0.7}, ["height_m = 0.7", "adults", "1.2 to 2.3", "child"]),
        ({"height_m": 1.19}, ["height_m = 1.19", "adults", "child"]),
        ({"height_m": 2.4}, ["height_m = 2.4", "between 1.2 and 2.3", "measure it again"]),
        ({"height_m": -1.75}, ["height_m = -1.75", "measure it again"]),
        ({"height_m": 0.0}, ["height_m = 0", "measure it again"]),
        ({"height_m": math.nan}, ["height_m = nan", "finite", "such as 1.75"]),
        ({"height_m": math.inf}, ["height_m = inf", "finite"]),
        ({"height_m": "1.75"}, ["height_m = '1.75'", "not a finite number"]),
        ({"height_m": True}, ["height_m = True", "not a finite number"]),
        ({"span_m": 178}, ["span_m = 178", "centimetres", "did you mean 1.78?"]),
        ({"span_m": 1.7, "height_m": 1.35}, ["span_m = 1.7", "height_m = 1.35", "1.26 of the height", "1.03"]),
        ({"span_m": 0.9}, ["span_m = 0.9", "middle of the chest", "did you mean 1.8?"]),
        ({"span_m": 1.05}, ["one arm", "did you mean 2.1?"]),
        ({"shoulder_height_m": 143}, ["centimetres", "did you mean 1.43?"]),
        ({"shoulder_height_m": 1.80}, ["shoulder_height_m = 1.8", "height_m = 1.75", "bony top"]),
        ({"shoulder_height_m": 1.75, "height_m": 1.43}, ["above the head", "the other way round?"]),
        ({"shoulder_height_m": 1.05}, ["shoulder_height_m = 1.05", "sitting", "standing"]),
        ({"shoulder_height_m": 0.6}, ["shoulder_height_m = 0.6", "bony top"]),
        ({"forearm_hand_m": 48}, ["centimetres", "did you mean 0.48?"]),
        ({"forearm_hand_m": 0.78}, ["forearm_hand_m = 0.78", "whole arm", "bent elbow"]),
        ({"forearm_hand_m": 0.19}, ["forearm_hand_m = 0.19", "0.11 of the height", "bent elbow"]),
        ({"seat_height_m": 45}, ["seat_height_m = 45", "centimetres", "did you mean 0.45?"]),
        ({"seat_height_m": 18}, ["seat_height_m = 18", "inches", "did you mean 0.4572?"]),
        ({"seat_height_m": 0.05}, ["seat_height_m = 0.05", "between 0.2 and 1"]),
        ({"sole_m": 25}, ["sole_m = 25", "millimetres", "did you mean 0.025?"]),
        ({"sole_m": 2.5}, ["sole_m = 2.5", "centimetres", "did you mean 0.025?"]),
        ({"sole_m": -0.01}, ["sole_m = -0.01", "between 0 and 0.15"]),
        ({"sole_m": math.nan}, ["sole_m = nan", "such as 0.025"]),
        ({"sex": "male"}, ["sex = 'male'", "'man', 'woman'", "did you mean 'man'?"]),
        ({"sex": "Woman"}, ["sex = 'Woman'", "did you mean 'woman'?"]),
        ({"arm": "both"}, ["arm = 'both'", "'right', 'left'", "choose one"]),
        ({"eye": "L"}, ["eye = 'L'", "'right', 'left', 'both'", "did you mean 'left'?"]),
        ({"eye": None}, ["eye = None", "choose one"]),
    ],
)
def test_says_in_one_sentence_what_to_type(typed: dict[str, object], parts: list[str]) -> None:
    text = complaint(**typed)
    assert [part for part in parts if part not in text] == []
    assert "\n" not in text
    assert ". " not in text


@pytest.mark.parametrize(
    ("height", "span", "shoulder", "forearm"),
    [
        (1.409, 1.3, 1.15, 0.37),
        (1.993, 2.1, 1.66, 0.56),
        (1.75, 0.915 * 1.75, 0.788 * 1.75, 0.2365 * 1.75),  # the survey's least shares
        (1.75, 1.151 * 1.75, 0.852 * 1.75, 0.3061 * 1.75),  # and its greatest
    ],
)
def test_accepts_everybody_in_the_survey(height: float, span: float, shoulder: float, forearm: float) -> None:
    told = Told(height_m=height, span_m=span, shoulder_height_m=shoulder, forearm_hand_m=forearm)
    assert told.span_m == span


@pytest.mark.parametrize("height", [1.2, 2.3])
def test_accepts_the_limits(height: float) -> None:
    assert Told(height_m=height).height_m == height


def test_knows_a_barefoot_right_hander_by_the_height_alone() -> None:
    told = Told(height_m=1.75)
    assert (told.sex, told.sole_m, told.seat_height_m, told.arm, told.eye, told.self_reported) == (
        None,
        0.0,
        None,
        "right",
        "right",
        False,
    )


def test_decoded_it_complains_in_the_same_words() -> None:
    with pytest.raises(msgspec.ValidationError, match=r"did you mean 1\.75"):
        msgspec.convert({"height_m": 175}, Told)


def test_decoded_it_knows_no_other_key() -> None:
    with pytest.raises(msgspec.ValidationError, match="weight_kg"):
        msgspec.convert({"height_m": 1.75, "weight_kg": 70}, Told)
