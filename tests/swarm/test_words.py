import pytest

from armspan.swarm.director import BEHAVIOURS
from armspan.swarm.words import WORDS, order_words


def test_every_behaviour_has_words_of_its_own():
    assert set(WORDS) == set(BEHAVIOURS)
    assert len(set(WORDS.values())) == len(WORDS)


@pytest.mark.parametrize(
    ("order", "words"),
    [
        ("gather", "come together"),
        ("sweep@garden", "cover garden in lanes"),
        ("deploy@garden", "spread out evenly in garden"),
        ("new-dance", "new dance"),
    ],
)
def test_an_order_in_words(order, words):
    assert order_words(order) == words
