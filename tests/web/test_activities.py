import pytest

from armspan.swarm.director import BEHAVIOURS
from armspan.web.activities import WORDS, in_words


def test_every_behaviour_has_words_of_its_own():
    assert set(WORDS) == set(BEHAVIOURS)
    assert len(set(WORDS.values())) == len(WORDS)


@pytest.mark.parametrize(
    ("order", "words"),
    [
        ("gather", "Come together"),
        ("sweep@garden", "Cover garden in lanes"),
        ("deploy@garden", "Spread out evenly in garden"),
        ("new-dance", "New dance"),
    ],
)
def test_an_order_in_words(order, words):
    assert in_words(order) == words
