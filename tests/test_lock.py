"""The locked versions: made of what is asked for today, each file with its digest, and no place to get it from."""

import hashlib
import json
import re
import tomllib

import pytest

from tests.conftest import ROOT

INPUTS = ("environment.txt", ".jupyterhub/requirements.txt", ".jupyterhub/proxy/package.json")
LOCKS = {"requirements": INPUTS[:1], "hub": INPUTS[:2]}
PIN = re.compile(r"^([\w.-]+)==([\w.+!]+)", re.MULTILINE)


def pins(text):
    return {re.sub(r"[-_.]+", "-", name).lower(): version for name, version in PIN.findall(text)}


def read(path):
    return (ROOT / path).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", LOCKS)
def test_a_lock_is_made_of_what_is_asked_for_today(name):
    digest = hashlib.sha256("".join(map(read, INPUTS)).encode()).hexdigest()
    lock = read(f".ci/{name}.lock")
    assert lock.startswith(f"# inputs {digest}\n"), "run .ci/lock"
    asked = {key: value for path in LOCKS[name] for key, value in pins(read(path)).items()}
    assert len(asked) > 15 and asked.items() <= pins(lock).items()
    building = tomllib.loads(read("pyproject.toml"))["build-system"]["requires"]
    assert building and {re.match(r"[\w-]+", each)[0] for each in building} <= pins(lock).keys()


@pytest.mark.parametrize("name", LOCKS)
def test_every_distribution_has_its_digests_and_no_address(name):
    entries = re.split(r"\n(?=\S)", read(f".ci/{name}.lock").strip())[1:]
    assert len(entries) > 80
    for entry in entries:
        assert PIN.match(entry) and re.search(r"--hash=sha256:[0-9a-f]{64}", entry), entry[:80]
        assert "://" not in entry and "index-url" not in entry and not entry.startswith(("-e", "mathpost"))


def test_the_proxys_packages_have_their_digests_and_no_address():
    lock = json.loads(read(".jupyterhub/proxy/package-lock.json"))
    asked = json.loads(read(".jupyterhub/proxy/package.json"))["dependencies"]
    packages = {path.removeprefix("node_modules/"): each for path, each in lock["packages"].items() if path}
    assert all(packages[name]["version"] == version for name, version in asked.items())
    for name, each in packages.items():
        assert each["integrity"].startswith("sha512-") and "resolved" not in each, name


def test_actions_are_taken_by_commit():
    for path in (ROOT / ".github/workflows").glob("*.yml"):
        used = re.findall(r"uses: (\S+)", path.read_text(encoding="utf-8"))
        assert used and all(re.fullmatch(r"[\w./-]+@[0-9a-f]{40}", each) for each in used), path
