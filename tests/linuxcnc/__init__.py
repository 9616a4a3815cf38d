"""Programs of the package on a real control, LinuxCNC in simulation; skipped where it is not installed."""
