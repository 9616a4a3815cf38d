"""The words of three controls, in one table."""

# For a `Command`: lines by its kind, or by its kind and what it switches to; {0} is its first value, {tool} the
# number of the tool, {name} the name of the program.
TABLE = {
    "control": ("heidenhain", "fanuc", "siemens"),
    "head": (
        ("BEGIN PGM {name} MM",),
        ("%", "O0001 ({name})", "G21 G17 G40 G90 G94"),
        ("; {name}", "G710 G17 G40 G90 G94"),
    ),
    "foot": (("END PGM {name} MM",), ("M30", "%"), ("M30",)),
    "block": ("", "N", "N"),  # the letter before its number,
    "unnumbered": ((), ("%", "O", ";", "("), ("%", "O", ";", "(")),  # and how lines without one begin
    "plus": ("+", "", ""),  # before a number that is not negative
    "comment": ("; {0}", "({0})", "; {0}"),
    "TCP on": ("M128", "G43.4 H{tool}", "TRAORI"),
    "TCP off": ("M129", "G49", "TRAFOOF"),
    "tool": (("TOOL CALL {0} Z",), ("T{0} M6",), ("T{0} D1", "M6")),
    "tip": ((), ("G43 H{0}",), ()),
    "spindle": (("TOOL CALL S{0:.0f}",), ("S{0:.0f}",), ("S{0:.0f}",)),
    "spindle CLW": (("M3",), ("M3",), ("M3",)),
    "spindle CCLW": (("M4",), ("M4",), ("M4",)),
    "spindle OFF": (("M5",), ("M5",), ("M5",)),
    "coolant": ((), (), ()),
    "coolant FLOOD": (("M8",), ("M8",), ("M8",)),
    "coolant MIST": (("M7",), ("M7",), ("M7",)),
    "coolant OFF": (("M9",), ("M9",), ("M9",)),
    "compensation LEFT": (" RL", " G41 D{tool}", " G41"),
    "compensation RIGHT": (" RR", " G42 D{tool}", " G42"),
    "compensation OFF": (" R0", " G40", " G40"),
    "dwell": (("CYCL DEF 9.0 DWELL TIME", "CYCL DEF 9.1 DWELL {0:.3f}"), ("G4 X{0:.3f}",), ("G4 F{0:.3f}",)),
    "stop": (("M0",), ("M0",), ("M0",)),
    "optional stop": (("M1",), ("M1",), ("M1",)),
    # The words without an axis that reading passes over, as regular expressions.
    "codes": (
        r"(?:M(?:0?[0134578]|0?9|128|129|30)|R[0LR]|S\d+|TOOL CALL S\d+|TOOL CALL \d+(?: Z)?|"
        r"CYCL DEF 9\.0 DWELL TIME|CYCL DEF 9\.1 DWELL \d+\.\d+)",
        r"(?:G4 X\d+\.\d+|G(?:21|17|4[0-2]|43(?:\.4)?|49|90)|M0?(?:[013-9])|M30|[HDSTO]\d+)",
        r"(?:G4 F\d+\.\d+|G(?:710|71|17|4[0-2]|90)|M0?(?:[013-9])|M30|TRAORI|TRAFOOF|[STD]\d+)",
    ),
}


HEIDENHAIN, FANUC, SIEMENS = ({key: row[n] for key, row in TABLE.items()} for n in range(3))
DIALECTS = {control["control"]: control for control in (HEIDENHAIN, FANUC, SIEMENS)}


def said(control, command):
    """Return the lines of a `Command` that needs no move."""
    lines = [line.format(*command.values) for line in control[command.kind] if command.values[:1] != (None,)]
    if command.kind in ("spindle", "coolant"):
        lines += control[f"{command.kind} {command.values[-1]}"]
    return lines
