"""Five-axis kinematics and post-processing, derived in sympy and taught in Jupyter."""
