from armspan.cli.typed import Lines


def typed(*chunks):
    pressed = []
    lines = Lines(lambda name, value: pressed.append((name, value)))
    for chunk in chunks:
        lines.feed(chunk)
    return pressed


def test_lines_are_presses_however_they_arrive():
    assert typed(b"behav", b"iour sweep@garden\nfeed", b"back on\nqu") == [
        ("behaviour", "sweep@garden"),
        ("feedback", "on"),
    ]


def test_enter_alone_stops_and_spaces_do_not_matter():
    assert typed(b"\n", b"  setup  \n", b"resume  amber \n") == [("stop", ""), ("setup", ""), ("resume", "amber")]


def test_what_is_no_press_is_answered_with_those_that_exist(capsys):
    assert typed(b"stopp\n\xff\xfe\n") == []
    _, err = capsys.readouterr()
    assert "'stopp' does not exist; there are: behaviour, feedback, quit, resume, setup, stop" in err
    assert "Did you mean 'stop'?" in err
