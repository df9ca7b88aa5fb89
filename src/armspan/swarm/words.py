"""Behaviours in a person's words."""

WORDS: dict[str, str] = {
    "random-walk": "wander about",
    "sweep": "cover the sheet in lanes",
    "deploy": "spread out evenly",
    "deploy-field": "spread out by pushing apart",
    "gather": "come together",
    "disperse": "go far apart",
    "follow": "follow where the arm points",
    "formation": "go to the pointed place in formation",
    "rotate-left": "turn round to the left",
    "rotate-right": "turn round to the right",
    "split": "split in two groups",
    "merge": "make one group again",
    "patrol": "visit the zones in turn",
    "leader": "one leads where the arm points",
    "come": "come to the person",
    "stop": "stop all robots",
}
"""Every behaviour; what is not here is said by its name."""


def order_words(order: str) -> str:
    """A behaviour, and the zone that it is for after an ``@``, in words."""
    name, _, zone = order.partition("@")
    words = WORDS.get(name, name.replace("-", " "))
    if not zone:
        return words
    return f"cover {zone} in lanes" if name == "sweep" else f"{words} in {zone}"
