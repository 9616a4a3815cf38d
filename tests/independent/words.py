"""A character scanner for blocks: comments, numbers, addresses, calls. No regular expressions."""

from dataclasses import dataclass


class Refused(Exception):
    """What the control would not take, with its line."""

    def __init__(self, line, why):
        self.line = line
        super().__init__(f"line {line}: {why}")


@dataclass
class Word:
    """An address with its number (`X12.5`), a name (`TRAORI`), or a call (`CYCLE800(…)`)."""

    name: str
    value: float | None = None
    point: bool = False  # the number had a decimal point
    arguments: tuple | None = None  # of a call, as text


def number_end(text, at):
    """Where the number that begins at `at` ends; `at` itself if none does."""
    end = at
    if end < len(text) and text[end] in "+-":
        end += 1
    digits = 0
    points = 0
    while end < len(text) and (text[end].isdigit() or text[end] == "."):
        digits += text[end].isdigit()
        points += text[end] == "."
        end += 1
    return end if digits and points <= 1 else at


def without_comments(text, line, round_brackets, semicolon):
    """The block without `(…)` and `;…`; an opened bracket must close on its line."""
    kept = []
    at = 0
    while at < len(text):
        character = text[at]
        if semicolon and character == ";":
            break
        if round_brackets and character == "(":
            close = text.find(")", at)
            if close < 0:
                raise Refused(line, "a comment that is not closed")
            at = close + 1
            continue
        if round_brackets and character == ")":
            raise Refused(line, "a bracket that was not opened")
        kept.append(character)
        at += 1
    return "".join(kept)


def split_arguments(text):
    """Split at commas outside of quotes and brackets."""
    parts = [""]
    depth = 0
    quoted = False
    for character in text:
        if character == '"':
            quoted = not quoted
        depth += (character == "(") - (character == ")")
        if character == "," and not quoted and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return tuple(part.strip() for part in parts)


def closing(text, at, line):
    """Where the bracket opened at `at` closes."""
    depth = 0
    quoted = False
    for n in range(at, len(text)):
        if text[n] == '"':
            quoted = not quoted
        if not quoted:
            depth += (text[n] == "(") - (text[n] == ")")
            if depth == 0:
                return n
    raise Refused(line, "a bracket that is not closed")


def scan(text, line, names=False):
    """The words of a block. With `names` (Siemens) also names and calls."""
    found = []
    at = 0
    while at < len(text):
        if text[at].isspace():
            at += 1
            continue
        start = at
        while at < len(text) and (text[at].isalpha() or (names and text[at] == "_")):
            at += 1
        name = text[start:at].upper()
        if not name:
            raise Refused(line, f"a character that begins no word: {text[start:]!r}")
        if len(name) > 1:
            if not names:
                raise Refused(line, f"a word this control does not know: {text[start:]!r}")
            while at < len(text) and (text[at].isalnum() or text[at] == "_"):
                at += 1
            name = text[start:at].upper()
        after = at
        while after < len(text) and text[after] == " ":
            after += 1
        if names and after < len(text) and text[after] == "(":
            close = closing(text, after, line)
            found.append(Word(name, arguments=split_arguments(text[after + 1 : close])))
            at = close + 1
            continue
        end = number_end(text, after) if len(name) == 1 else after
        if end > after:
            found.append(Word(name, float(text[after:end]), "." in text[after:end]))
            at = end
        elif len(name) == 1:
            raise Refused(line, f"{name} without a number")
        else:
            found.append(Word(name))
    return found
