"""Whom a command is for, among simulated robots."""

from collections.abc import Iterable, Mapping

from armspan.errors import DeviceNotFound, known_names


def addressed(robot: str | None, number: Mapping[str, int]) -> Iterable[int]:
    """The numbers of the robots that a command is for: one by its name, or all of them.

    Raises:
        DeviceNotFound: for a robot that does not exist.

    """
    if robot is None:
        return number.values()
    if robot not in number:
        raise DeviceNotFound(known_names("robot", robot, number))
    return (number[robot],)
