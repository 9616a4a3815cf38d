"""The locked versions: made of what is asked for today, each file with its digest, and no place to get it from."""

import hashlib
import re
import tomllib

from tests.conftest import ROOT

PIN = re.compile(r"^([\w.-]+)==([\w.+!]+)", re.MULTILINE)


def pins(text):
    return {re.sub(r"[-_.]+", "-", name).lower(): version for name, version in PIN.findall(text)}


def read(path):
    return (ROOT / path).read_text(encoding="utf-8")


def test_the_lock_is_made_of_what_is_asked_for_today():
    asked, project, lock = map(read, ("environment.txt", "pyproject.toml", ".ci/requirements.lock"))
    said = "".join(re.findall(r"^(?:site|tests) = .*?^\]\n", project, re.MULTILINE | re.DOTALL))
    digest = hashlib.sha256((asked + said).encode()).hexdigest()
    assert lock.startswith(f"# inputs {digest}\n"), "run .ci/lock"
    extras = tomllib.loads(project)["project"]["optional-dependencies"]
    tests = pins("\n".join(extras["site"] + extras["tests"]))
    assert len(pins(asked)) > 10 and len(tests) > 8 and not pins(asked).keys() & tests.keys()
    assert (pins(asked) | tests).items() <= pins(lock).items()
    building = tomllib.loads(project)["build-system"]["requires"]
    assert building and {re.match(r"[\w-]+", each)[0] for each in building} <= pins(lock).keys()


def test_every_distribution_has_its_digests_and_no_address():
    entries = re.split(r"\n(?=\S)", read(".ci/requirements.lock").strip())[1:]
    assert len(entries) > 80
    for entry in entries:
        assert PIN.match(entry) and re.search(r"--hash=sha256:[0-9a-f]{64}", entry), entry[:80]
        assert "://" not in entry and "index-url" not in entry and not entry.startswith(("-e", "mathpost"))


def test_actions_are_taken_by_commit():
    for path in (ROOT / ".github/workflows").glob("*.yml"):
        used = re.findall(r"uses: (\S+)", path.read_text(encoding="utf-8"))
        assert used and all(re.fullmatch(r"[\w./-]+@[0-9a-f]{40}", each) for each in used), path
