"""The site, built once, and the browser of the other tests."""

import contextlib
import io

import pytest

from mathpost.interface.shell.main import main
from tests.conftest import ROOT
from tests.test_browser import browser, offline  # noqa: F401, fixtures


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The folder that the command makes of the course."""
    folder = tmp_path_factory.mktemp("site") / "html"
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        assert main(["site", str(ROOT / "notebooks"), "-o", str(folder)]) == 0
    lines = [line for line in said.getvalue().splitlines() if line and "inventor" not in line]  # of other projects
    assert lines == []
    return folder
