"""The Chinese of the report on a class, by the English text: `chinese.toml`, and `exercises.toml` for its slips."""

import re
from functools import cache

from mathpost.course.lesson_data import toml
from mathpost.course.verdict import EXERCISES


def word(text):
    """A word of the report, or a cause that the check of workbooks names."""
    if text in (words := sections()["report"]):
        return words[text]
    from mathpost.workbook.folder import CHINESE  # slow to import, and needed for workbooks only

    return CHINESE.get(text, text)


@cache
def mixup(name, sentence):
    """What is said of a mix-up of an exercise; "" if that has no Chinese, as in a teacher's own exercise."""
    for pattern, chinese in (*_patterns(name), *_patterns("any")):
        if found := pattern.fullmatch(sentence):
            return chinese.format(*(mixup(name, part) or part for part in found.groups()))
    if name not in EXERCISES or not EXERCISES[name].detective:
        return ""
    parts = sentence
    for pattern, chinese in _patterns("detective"):
        parts = pattern.sub(lambda found, chinese=chinese: chinese.format(*found.groups()), parts)
    return "" if parts == sentence else parts.removesuffix(".") + "。"


@cache
def sections():
    """The Chinese by section: those of the file, and one for each exercise of the lessons."""
    found = dict(toml("chinese"))
    for name, words in toml("exercises").items():
        slips = {sentence: entry["zh"] for sentence, entry in words.get("slips", {}).items()}
        found[name] = slips | words.get("said", {})
    return found


@cache
def _patterns(section):
    """The entries of a section, the keys as patterns; the parts of a detective's sentence differ in a word each."""
    blank, ignore = (r"(\S+?)", re.IGNORECASE) if section == "detective" else ("(.+?)", 0)
    entries = sections().get(section, {}).items()
    return [(re.compile(re.escape(key).replace(r"\{\}", blank), ignore), chinese) for key, chinese in entries]
