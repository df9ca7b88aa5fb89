import msgspec
import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.pointing.calibration import Noise, calibrate
from armspan.pointing.pairs import moving_pairs, still_pairs
from armspan.pointing.parameters import parameters
from armspan.pointing.priors import PITCH_SD, Priors, Refined
from straight_arms import BODY, place_before, pointing_at, seen_from, with_x

WIDE = np.array([[x, y, 0.0] for x in np.linspace(0.0, 2.0, 5) for y in np.linspace(0.0, 2.0, 5)])
SD = np.array([0.008, 0.022, 0.008, 0.023, 0.025])
DOUBTED = msgspec.structs.replace(BODY, covariance=tuple(np.diag(SD**2).ravel()))
NAMES = ["x", "y", "z", "yaw", "pitch", "eye height", "forward", "left", "up", "arm length"]


def fit_of(priors, points=WIDE, degrees=0.1, body=DOUBTED, z_up=False):
    xyz = place_before(points, [1.2, 0.1, 0.3], 0.5, z_up=z_up)
    x = pointing_at(seen_from(points, xyz, 0.5, z_up=z_up))[:, :, 0]
    x = x + np.radians(degrees) * np.random.default_rng(0).normal(size=x.shape)
    forearm = with_x(x / np.linalg.norm(x, axis=1, keepdims=True))
    pairs = still_pairs(forearm, None, points, tuple(str(k) for k in range(len(points))))
    noise = Noise(float(np.radians(degrees)), 1e9)
    return calibrate(body, pairs, "head-finger", priors=priors, noise=noise, z_up=z_up)


def table(fit):
    return {parameter.name: parameter for parameter in fit.parameters}


def test_a_plain_fit_has_no_table():
    assert fit_of(Priors()).parameters == ()


def test_exact_pointing_over_a_wide_area_determines_what_a_few_rough_stops_do_not():
    priors = Priors(pitch_sd=PITCH_SD, measures=True)
    exact, rough = table(fit_of(priors)), table(fit_of(priors, WIDE[[0, 4, 20, 24]], 2.0))
    assert list(exact) == list(rough) == NAMES
    assert exact["up"].verdict == "determined by the data"
    assert exact["pitch"].verdict == "determined by the data"
    assert [rough[name].verdict for name in ("forward", "left", "arm length")] == ["prior only"] * 3
    for name in ("forward", "left", "up", "arm length", "pitch"):
        assert exact[name].sd < rough[name].sd <= rough[name].prior_sd * 1.0001


def test_what_was_assumed_and_what_was_found_stand_side_by_side():
    fit = fit_of(Priors(measures=True))
    found = table(fit)
    for k, name in enumerate(("forward", "left", "up")):
        assert found[name].prior == BODY.shoulder_to_eye_m[k]
        assert found[name].value == fit.body.shoulder_to_eye_m[k]
        assert_allclose(found[name].prior_sd, SD[k + 1])
    assert (found["arm length"].prior, found["arm length"].value) == (0.72, fit.body.shoulder_to_fingertip_m)
    assert_allclose(found["arm length"].prior_sd, 0.025)
    assert_allclose([found["x"].sd, found["yaw"].sd], np.sqrt(np.diagonal(fit.covariance))[[0, 3]])
    assert (found["x"].prior, found["x"].prior_sd, found["x"].verdict) == (None, None, "determined by the data")
    assert (found["pitch"].prior_sd, found["pitch"].verdict) == (0.0, "as given")


def test_the_sd_of_a_found_measure_is_its_scatter():
    """Bodies drawn from the prior, arms that point with noise: the error of what is found, over its told doubt."""
    rng, scores = np.random.default_rng(1), []
    xyz = place_before(WIDE, [1.2, 0.1, 0.3], 0.5)
    for _ in range(40):
        forward, left, up = np.array(BODY.shoulder_to_eye_m) + SD[1:4] * rng.normal(size=3)
        arm = 0.72 + SD[4] * rng.normal()
        true = msgspec.structs.replace(BODY, shoulder_to_eye_m=(forward, left, up), shoulder_to_fingertip_m=arm)
        x = pointing_at(seen_from(WIDE, xyz, 0.5), true)[:, :, 0]
        x = x + np.radians(0.3) * rng.normal(size=x.shape)
        forearm = with_x(x / np.linalg.norm(x, axis=1, keepdims=True))
        pairs = moving_pairs(forearm, None, WIDE, np.linspace(0.0, 75.0, 25))  # far enough apart to count fully
        noise = Noise(float(np.radians(0.3)), 1e9)
        found = table(calibrate(DOUBTED, pairs, "head-finger", priors=Priors(measures=True), noise=noise))
        pairs_of = (("forward", forward), ("left", left), ("up", up), ("arm length", arm))
        scores.append([(found[name].value - value) / found[name].sd for name, value in pairs_of])
    assert_allclose(np.sqrt(np.mean(np.square(scores), axis=0)), 1.0, atol=0.3)


def test_the_eyes_height_is_never_told():
    found = table(fit_of(Priors(measures=True)))["eye height"]
    assert (found.value, found.prior, found.sd) == (1.65, 1.65, 0.008)
    assert found.verdict == "not told apart from the sheet's height"
    assert table(fit_of(Priors(pitch_sd=PITCH_SD), body=BODY))["eye height"].sd is None


@pytest.mark.parametrize(("z_up", "sign"), [(False, 1.0), (True, -1.0)])
def test_a_told_height_is_the_prior_of_z(z_up, sign):
    found = table(fit_of(Priors(plane_height=(0.3, 0.006)), z_up=z_up))["z"]
    assert_allclose(found.prior, sign * 0.3)
    assert_allclose(found.prior_sd, 0.01)  # 6 mm of the table and 8 mm of the eye
    assert_allclose(found.value, sign * 0.3, atol=0.01)


@pytest.mark.parametrize(
    ("share", "verdict"),
    [(0.49, "determined by the data"), (0.51, "partly"), (0.89, "partly"), (0.91, "prior only")],
)
def test_verdicts_go_by_the_share_of_the_prior_that_is_left(share, verdict):
    found = Refined(np.zeros(4), np.eye(4), DOUBTED, 0.0, None, share * np.array([*SD[1:], PITCH_SD]))
    rows = parameters(np.zeros(4), np.eye(4), DOUBTED, found, Priors(None, PITCH_SD, True), z_up=False)
    assert {row.verdict for row in rows if row.name in ("pitch", "forward", "left", "up", "arm length")} == {verdict}
