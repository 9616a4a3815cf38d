"""What nbval cannot see: notebooks that were stripped, fail quietly, or grow out of their rhythm."""

import ast
import json
import re
import subprocess
import sys

import pytest

from tests.conftest import LESSONS, README, ROOT


def read(path):
    """The cells of a notebook."""
    return json.loads(path.read_text(encoding="utf-8"))


def test_every_notebook_is_collected_as_tests():
    """By the settings of the project alone: an old pytest that did not know them would run none, and be green."""
    command = "-m pytest --collect-only -q -n 0 -p no:cacheprovider notebooks".split()
    listed = subprocess.run([sys.executable, *command], cwd=ROOT, capture_output=True, text=True).stdout
    notebooks = (ROOT / "notebooks").glob("*.ipynb")
    assert [path.name for path in notebooks if not re.search(rf"{re.escape(path.name)}(: |::)", listed)] == []


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_committed_with_outputs(path):
    notebook = read(path)
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert notebook["metadata"]["kernelspec"]["name"] == "python3"
    assert "widgets" not in notebook["metadata"]
    assert all(cell["execution_count"] for cell in code), "run it anew and commit the outputs"
    assert not any(output["output_type"] == "error" for cell in code for output in cell["outputs"])
    assert path.stat().st_size < 1_000_000


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_rhythm(path):
    cells = read(path)["cells"]
    title, picture, goals = ("".join(cell["source"]) for cell in cells[:3])
    assert title.startswith("# " + path.stem[:2]), "the title begins with the number of the lesson"
    for word in ("**You need first**", "**Time**"):
        assert word in title, f"the first cell says {word}"
    assert re.search("mathpost-live|image/png", str(cells[1]["outputs"])), "the second cell shows the question"
    assert len(picture.splitlines()) <= 8 or "source_hidden" in str(cells[1]["metadata"]), "the code is closed"
    assert goals.startswith("**Afterwards you can**"), "the third cell begins with what a reader learns"
    for cell in cells:
        if cell["cell_type"] == "code":
            lines = "".join(cell["source"]).splitlines()
            length = sum(bool(line.strip()) and not line.startswith(("import ", "from ")) for line in lines)
            assert length <= 15, f"a cell of {length} lines: a learner reads 15 at most"
    links = [part.split(")")[0] for cell in cells for part in "".join(cell["source"]).split("](")[1:]]
    for link in links:
        if link.endswith(".ipynb"):
            assert (path.parent / link).exists(), f"a link to {link}, which is not there"


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_no_answer_is_seen_before_the_guess(path):
    """Nothing that gives the answer away is stored, nor shown when the lesson runs without a guess."""
    cells = read(path)["cells"]
    for number, cell in enumerate(cells):
        source = "".join(cell["source"])
        if cell["cell_type"] == "code" and "exercise.after(" in source:
            assert not any(output["output_type"] != "stream" for output in cell["outputs"]), source
        if cell["cell_type"] == "code" and "exercise.reveal(" in source:
            shown = "".join("".join(output.get("text", "")) for output in cell["outputs"])
            assert all(line.startswith("Write a guess") for line in shown.splitlines()), source
            following = number + 1
            while "exercise.after(" in "".join(cells[following]["source"]):
                following += 1
            assert "".join(cells[following]["source"]).startswith("<details>"), f"fold what follows: {source}"


def bound(statements):
    """The names that statements bind in the notebook: not those inside a function or a comprehension."""
    inside = (ast.Lambda, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
    queue = list(statements)
    while queue:
        node = queue.pop()
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.alias):
            yield (node.asname or node.name).split(".")[0]
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif not isinstance(node, inside):
            queue += ast.iter_child_nodes(node)


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_no_answer_takes_a_name_of_its_lesson(path):
    """Otherwise a cell of the lesson that is run again finds the answer in the place of its own."""
    own, stubs = set(), []
    for cell in read(path)["cells"]:
        if cell["cell_type"] == "code":
            statements = ast.parse("".join(cell["source"])).body
            empty = [
                ast.unparse(each).removesuffix(" = None")
                for each in statements
                if ast.unparse(each).endswith(" = None")
            ]
            stubs += empty
            own |= set(bound(statements)) - set(empty)
    assert own.isdisjoint(stubs) and len(set(stubs)) == len(stubs), sorted(own & set(stubs)) or sorted(stubs)


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_the_syllabus_states_the_lessons_minutes(path):
    minutes = re.search(
        r"\*\*Time\*\*\D*(\d+)", "".join("".join(cell["source"]) for cell in read(path)["cells"][:3])
    )
    (row,) = (line for line in README.splitlines() if f"{path.name})" in line)
    assert row.split("|")[-2].strip() == minutes[1], "the README's table states other minutes than the lesson"


def test_the_readme_and_ci_run_the_same_line():
    line = 'python3 -m venv .venv && .venv/bin/pip install -r environment.txt -e ".[tests]" && .venv/bin/pytest'
    assert line in README.splitlines()
    assert f'{line} "$@"' in (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()


def test_the_first_lesson_and_the_readme_have_the_same_syllabus():
    rows = [line.split("|")[1:-2] for line in README.splitlines() if line.startswith("| [")]
    shown = [[cell.strip().replace("(notebooks/", "(") for cell in row] for row in rows]
    table = "".join("".join(cell["source"]) for cell in read(LESSONS[0])["cells"])
    assert [name for name, source, after in shown[1:] if f"| {name} | {after} | {source} |" not in table] == []


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_every_section_that_a_lesson_names_is_there(path):
    """In the lesson that the sentence links to, otherwise in the same one."""

    def texts(lesson):
        cells = json.loads(lesson.read_text(encoding="utf-8"))["cells"]
        return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown"]

    for text in texts(path):
        for sentence in re.split(r"(?<=[.?!:)])\s+(?=[A-Z*(\[])|\n\n", text):
            for named in re.findall(r"(?<!G)\b[Ss]ections? (\d+(?: (?:to|and) \d+)*)", sentence):
                links = re.findall(r"\((\w+\.ipynb)\)", sentence)
                for lesson in re.findall(r"\((\d\d[a-c]?), section", sentence):
                    links = [each.name for each in LESSONS if each.name.startswith(f"{lesson}_")]
                heads = "\n".join(texts(path.parent / links[-1] if links else path))
                for number in re.findall(r"\d+", named):
                    assert re.search(rf"^## {number} · ", heads, re.M), sentence
