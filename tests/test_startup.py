"""What starting costs: no module is loaded before it is needed."""

import subprocess
import sys

import pytest


def loaded_after(statement):
    """Names of the modules that a fresh interpreter has loaded after a statement."""
    code = f"import sys; {statement}; print(*sys.modules)"
    return set(
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    )


def test_import_loads_neither_sympy_nor_matplotlib():
    assert not loaded_after("import mathpost") & {"sympy", "matplotlib", "scipy", "numpy"}


@pytest.mark.parametrize("module", ["post", "__main__", "post.cl", "kinematics"])
def test_post_processing_loads_no_pictures(module):
    assert not loaded_after(f"import mathpost.{module}") & {"matplotlib", "ipywidgets"}
