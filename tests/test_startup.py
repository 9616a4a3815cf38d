"""What starting costs, and what the package offers under its own name: nothing is loaded before it is used."""

import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import mathpost

ROOT = Path(__file__).parent.parent


def loaded_after(statement):
    """Names of the modules that a fresh interpreter has loaded after a statement."""
    code = f"import sys; {statement}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_import_loads_nothing_else():
    loaded = loaded_after("import mathpost; dir(mathpost)")
    assert {name for name in loaded if name.startswith("mathpost")} == {"mathpost"}
    assert not loaded & {"sympy", "matplotlib", "scipy", "numpy"}


def test_help_loads_no_library():
    loaded = loaded_after("from mathpost.interface.shell import main; main._parser(['--help'])")
    assert not loaded & {"sympy", "matplotlib", "scipy", "numpy"}


@pytest.mark.parametrize("module", ["shop.post.postprocess", "interface.shell.post", "path.cl", "kinematics"])
def test_post_processing_loads_no_pictures(module):
    assert "matplotlib" not in loaded_after(f"import mathpost.{module}")


def test_what_is_offered_is_there_and_shadows_no_module():
    modules = {name.split(".")[-1] for _, name, _ in pkgutil.iter_modules(mathpost.__path__, "mathpost.")}
    assert set(mathpost.__all__) <= set(dir(mathpost))
    for name in mathpost.__all__:
        assert callable(getattr(mathpost, name)) and name not in modules
    assert mathpost.load_machine("data/machines/dmu50v.toml").arrangement == "table-table"


def test_an_unknown_name_is_an_error_and_a_module_stays_one():
    with pytest.raises(AttributeError, match="module 'mathpost' has no attribute 'dough'"):
        mathpost.dough  # noqa: B018
    assert "load" in vars(sys.modules["mathpost.machine_file"])
    loaded_after("from mathpost import machine_file, load_machine; assert machine_file.load is load_machine")
