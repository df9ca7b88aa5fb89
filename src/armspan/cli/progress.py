"""Live progress in the terminal: the sheet from above in characters, what is said, what is pointed at."""

from collections import deque
from types import TracebackType

from rich.console import Console, Group
from rich.live import Live
from rich.panel import Panel
from rich.text import Text

from armspan.conductor import Settings
from armspan.records import Light, Pointed, Press, Record, RobotState, Say, Selected
from armspan.study.trials import zone_middle

_COLUMNS = 64
_LINES = 5


class Progress:
    """A sink that draws what happens on stderr, ten times a second; shows nothing unless asked to."""

    def __init__(self, settings: Settings, *, shown: bool) -> None:
        self.settings, self.shown = settings, shown
        self._robots: dict[str, RobotState] = {}
        self._colours: dict[str, str] = {}
        self._pointed: Pointed | None = None
        self._target = ""
        self._said: deque[str] = deque(maxlen=_LINES)
        self._drawn = -1.0
        self._live = Live(console=Console(stderr=True), auto_refresh=False, transient=True)

    def __enter__(self) -> "Progress":
        if self.shown:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.shown:
            self._live.stop()

    def __call__(self, record: Record) -> None:
        """Take note of a record, and draw when it is time."""
        match record:
            case RobotState():
                self._robots[record.robot] = record
            case Pointed():
                self._pointed = record
            case Light():
                self._colours[record.robot] = "#{:02x}{:02x}{:02x}".format(*record.colour)
            case Say():
                self._say(record.t, record.text)
            case Press(name="trial"):
                self._target = record.value
            case Press(name="feedback"):
                self._say(
                    record.t,
                    f"The robots' lights {'now show' if record.value == 'on' else 'do not show'} the cursor",
                )
            case Selected():
                right = (
                    ""
                    if not self._target
                    else " ✓"
                    if self._target.endswith(f":{record.robot or record.zone}")
                    else " ✗"
                )
                self._say(record.t, f"Chosen: {record.robot or record.zone}, {record.probability:.0%}{right}")
            case _:
                pass
        if self.shown and record.t - self._drawn > 0.1:
            self._drawn = record.t
            self._live.update(self._picture(record.t), refresh=True)

    def _say(self, t: float, text: str) -> None:
        self._said.append(f"{t:6.1f} s  {text}")

    def _picture(self, t: float) -> Group:
        title = f"{t:.0f} s" + (f" · asked to point at {self._target}" if self._target else "")
        return Group(Panel(self._sheet(), title=title, width=_COLUMNS + 4), Text("\n".join(self._said)))

    def _sheet(self) -> Text:
        """The sheet as a grid of characters, its y downwards as printed."""
        sheet = self.settings.sheet
        rows = max(8, round(_COLUMNS * sheet.height_m / sheet.width_m / 2))
        grid = [[(" ", "")] * _COLUMNS for _ in range(rows)]

        def put(x: float, y: float, text: str, style: str) -> None:
            column = round(x / sheet.width_m * (_COLUMNS - 1)) - len(text) // 2
            row = round(y / sheet.height_m * (rows - 1))
            for k, letter in enumerate(text):
                if 0 <= row < rows and 0 <= column + k < _COLUMNS:
                    grid[row][column + k] = (letter, style)

        for zone in self.settings.zones:
            put(*zone_middle(zone), f"({zone.name})", "dim")
        for name, state in self._robots.items():
            put(
                *state.xy,
                f"[{name}]",
                f"bold {self._colours.get(name, '#ffffff')}".replace("#000000", "white"),
            )
        if self._pointed is not None and self._pointed.xy is not None:
            put(*self._pointed.xy, "✛", "bold magenta")
        text = Text()
        for number, row in enumerate(grid):
            for letter, style in row:
                text.append(letter, style)
            text.append("\n" if number < rows - 1 else "")
        return text
