"""The site, built once, and the browser of the other tests."""

import pytest

from mathpost.interface.shell.main import main
from tests.conftest import ROOT
from tests.test_browser import browser, offline  # noqa: F401, fixtures


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The folder that the command makes of the course."""
    folder = tmp_path_factory.mktemp("site") / "html"
    assert main(["site", str(ROOT / "notebooks"), "-o", str(folder)]) == 0
    return folder
