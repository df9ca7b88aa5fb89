import pytest

from armspan.conductor.conductor import Conductor
from armspan.conductor.gestures import with_threshold
from armspan.errors import ConfigError
from armspan.gesture.training import Wanted, train
from armspan.records import Press, Say
from gesture.made_takes import made_takes
from puppet import settings


@pytest.fixture(scope="module")
def model():
    return train(made_takes(3, rest=1.0), Wanted(folds=2))


def test_a_threshold_is_part_of_the_model(model):
    surer = with_threshold(model, "0.75")
    assert surer.facts.rule == model.facts.rule.at(0.75)
    assert surer.windows is model.windows
    assert with_threshold(surer, f"{model.facts.rule.threshold}").facts.rule == model.facts.rule


@pytest.mark.parametrize("text", ["", "much", "nan", "0", "0.05", "1.0", "-inf"])
def test_a_threshold_is_a_probability(model, text):
    with pytest.raises(ConfigError, match="expected a probability from"):
        with_threshold(model, text)


def test_without_a_model_there_is_no_threshold():
    with pytest.raises(ConfigError, match="train one first"):
        with_threshold(None, "0.5")
    (told,) = Conductor(settings()).step(Press(1.0, "threshold", "0.5"))
    assert isinstance(told, Say)
    assert told.text.startswith("Nothing was changed: this room has no gesture model")
