from armspan.web.activities import in_words


def test_an_activity_is_named_like_a_sentence_begins():
    assert in_words("sweep@garden") == "Cover garden in lanes"
    assert in_words("gather") == "Come together"
