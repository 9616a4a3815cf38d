"""Numbers in the prose of lessons: a false one fails, and the failure says what it is now."""

import shutil

import nbformat

from tests.conftest import ROOT

pytest_plugins = ["pytester"]

MEASURED = "lean, count = 4.4123, 3"
PROSE = "By **4.4°**<!-- lean .1f --> in 3<!-- count d --> rows, −4.41<!-- -lean .2f -->."
FALSE = {
    ("4.4°", "9.9°"): "the text says 9.9, lean is 4.4",
    ("in 3<", "in 4<"): "the text says 4, count is 3",
    ("−4.41", "4.41"): "the text says 4.41, -lean is -4.41",
    ("lean .1f", "leap .1f"): "the text says 4.4, leap .1f cannot be measured: name 'leap' is not defined",
    ("By **4.4°**", "By"): "the text says no number before the mark, lean is 4.4",
}


def run_lesson(pytester, *texts):
    """Run a lesson of one measurement and these texts with the notebooks' own conftest, in another process."""
    shutil.copy(ROOT / "notebooks/conftest.py", pytester.path)
    cells = [nbformat.v4.new_code_cell(MEASURED), *map(nbformat.v4.new_markdown_cell, texts)]
    cells.append(nbformat.v4.new_code_cell("lean = 9"))  # prose is measured where it stands
    nbformat.write(nbformat.v4.new_notebook(cells=cells), pytester.path / "lesson.ipynb")
    return pytester.runpytest_subprocess("--nbval", "--nbval-current-env")


def test_true_numbers_pass_and_false_ones_fail_with_what_they_are(pytester):
    result = run_lesson(pytester, PROSE, *(PROSE.replace(*pair) for pair in FALSE), "No mark: 17.")
    result.assert_outcomes(passed=3, failed=len(FALSE))
    for sentence in FALSE.values():
        result.stdout.fnmatch_lines([sentence])
