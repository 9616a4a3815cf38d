"""Plain loops as machine code, where Numba is installed."""

from functools import cache


@cache
def compiled(loop, *helpers):
    """A loop that calls `helpers` as machine code, kept if there is a folder for it; as it stands without Numba."""
    try:
        from numba import njit
        from numba.extending import register_jitable
    except ImportError:
        return loop
    for function in helpers:
        register_jitable(function)
    try:
        return njit(cache=True, error_model="numpy")(loop)
    except RuntimeError:  # neither here nor in the home folder
        return njit(error_model="numpy")(loop)
