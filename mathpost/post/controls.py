"""The words of three controls."""

from dataclasses import dataclass

SWITCHES = {
    ("spindle", "CLW"): "M3",
    ("spindle", "CCLW"): "M4",
    ("spindle", "OFF"): "M5",
    ("coolant", "FLOOD"): "M8",
    ("coolant", "MIST"): "M7",
    ("coolant", "OFF"): "M9",
    "stop": ("M0",),
    "optional stop": ("M1",),
}


@dataclass(frozen=True, eq=False)
class Control:
    """The words of a control."""

    name: str
    head: tuple  # lines before the moves; {name} in them is the name of the program
    foot: tuple
    tcp_on: str  # makes the control keep the tip
    tcp_off: str
    comment: tuple  # what stands before and after a comment
    words: dict  # for a `Command`: lines by its kind, or by what it switches to; {0} is its first value
    codes: str  # the words without an axis that reading passes over, as a regular expression
    number_letter: str = "N"
    sign: str = ""  # before a number that is not negative

    def lines(self, command):
        """Return the lines of a `Command` that needs no move."""
        lines = self.words.get(command.kind, ())
        if command.kind == "spindle":
            lines = () if command.values[0] is None else lines
        if command.kind in ("spindle", "coolant"):
            lines = (*lines, self.words[command.kind, command.values[-1]])
        return [line.format(*command.values) for line in lines]


HEIDENHAIN = Control(
    name="heidenhain",
    head=("BEGIN PGM {name} MM",),
    foot=("END PGM {name} MM",),
    tcp_on="M128",
    tcp_off="M129",
    comment=("; ", ""),
    words=SWITCHES
    | {
        "tool": ("TOOL CALL {0} Z",),
        "spindle": ("TOOL CALL S{0:.0f}",),
        "dwell": ("CYCL DEF 9.0 DWELL TIME", "CYCL DEF 9.1 DWELL {0:.3f}"),
        ("compensation", "LEFT"): " RL",
        ("compensation", "RIGHT"): " RR",
        ("compensation", "OFF"): " R0",
    },
    codes=(
        r"(?:M(?:0?[0134578]|0?9|128|129|30)|R[0LR]|S\d+|TOOL CALL S\d+|TOOL CALL \d+(?: Z)?|"
        r"CYCL DEF 9\.0 DWELL TIME|CYCL DEF 9\.1 DWELL \d+\.\d+)"
    ),
    number_letter="",
    sign="+",
)
ISO = SWITCHES | {"spindle": ("S{0:.0f}",), ("compensation", "OFF"): " G40"}
FANUC = Control(
    name="fanuc",
    head=("%", "O0001 ({name})", "G21 G17 G40 G90 G94"),
    foot=("M30", "%"),
    tcp_on="G43.4 H{tool}",
    tcp_off="G49",
    comment=("(", ")"),
    words=ISO
    | {
        "tool": ("T{0} M6",),
        "tip": ("G43 H{0}",),
        "dwell": ("G4 X{0:.3f}",),
        ("compensation", "LEFT"): " G41 D{tool}",
        ("compensation", "RIGHT"): " G42 D{tool}",
    },
    codes=r"(?:G4 X\d+\.\d+|G(?:21|17|4[0-2]|43(?:\.4)?|49|90)|M0?(?:[013-9])|M30|[HDSTO]\d+)",
)
SIEMENS = Control(
    name="siemens",
    head=("; {name}", "G710 G17 G40 G90 G94"),
    foot=("M30",),
    tcp_on="TRAORI",
    tcp_off="TRAFOOF",
    comment=("; ", ""),
    words=ISO
    | {
        "tool": ("T{0} D1", "M6"),
        "dwell": ("G4 F{0:.3f}",),
        ("compensation", "LEFT"): " G41",
        ("compensation", "RIGHT"): " G42",
    },
    codes=r"(?:G4 F\d+\.\d+|G(?:710|71|17|4[0-2]|90)|M0?(?:[013-9])|M30|TRAORI|TRAFOOF|[STD]\d+)",
)
DIALECTS = {control.name: control for control in (HEIDENHAIN, FANUC, SIEMENS)}
