"""How a phone finds the page: a picture for its camera, and the address below it."""


def join_text(url: str) -> str:
    """A QR code of half blocks for a terminal, dark on light whatever the terminal's colours, and the URL."""
    import segno  # here, so that nobody waits for it who shows no code

    rows = [list(row) for row in segno.make(url, error="l", micro=False).matrix_iter(border=2)]
    if len(rows) % 2:
        rows.append([0] * len(rows[0]))
    lines = [
        "\x1b[30;107m"
        + "".join(_BLOCKS[bool(above), bool(below)] for above, below in zip(*pair, strict=True))
        + "\x1b[0m"
        for pair in zip(rows[::2], rows[1::2], strict=True)
    ]
    return "\n".join([*lines, url])


_BLOCKS = {(False, False): " ", (True, False): "▀", (False, True): "▄", (True, True): "█"}
