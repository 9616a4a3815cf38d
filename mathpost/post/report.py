"""The report on a program: what was chosen, what was proved, and how the alternatives compare."""

from dataclasses import dataclass

import numpy as np

from mathpost.post.verification import Verification


@dataclass(frozen=True)
class Report:
    """All that a person wants to know of a program before running it; ``print(report)`` shows it.

    Attributes
    ----------
    verification : Verification
    settings : dict
        What the program was made with, as text.
    time : float
        Seconds; 0 if neither feed nor rates are known.
    uncompensated : Verification or None
        What the calibrated machine would do with the program, had it not been compensated for.
    warnings : tuple of str
    strategies : tuple of tuples
        Selection strategy; cost; largest step of each rotary axis, degrees; why it is not possible.
    passages : dict
        For each singular region (first and last record, from 0) the ways through, as a list of `Passage`.
    """

    verification: Verification
    settings: dict
    time: float
    warnings: tuple
    strategies: tuple
    passages: dict
    uncompensated: Verification | None = None

    @property
    def tip_error(self):
        """Largest distance of the tip from the CL data at the records, mm."""
        return self.verification.tip_error

    @property
    def axis_error(self):
        """Largest angle of the tool axis from the CL data at the records, degrees."""
        return self.verification.axis_error

    @property
    def path_tip_error(self):
        """Largest distance of the tip from the CL path anywhere in cut, mm."""
        return self.verification.path_tip_error

    @property
    def path_axis_error(self):
        """Largest angle of the tool axis from the great circle between the CL axes anywhere in cut, degrees."""
        return self.verification.path_axis_error

    def __str__(self):
        proof = self.verification
        lines = [f"{key:<12} {value}" for key, value in self.settings.items()]
        if self.time > 0:
            lines.append(f"{'time':<12} {self.time:.2f} s")
        lines += [
            f"{'tip error':<12} {proof.tip_error:.4f} mm at the records, "
            f"{proof.path_tip_error:.4f} mm along the path (most before record {proof.worst_record})",
            f"{'axis error':<12} {proof.axis_error:.4f}° at the records, "
            f"{proof.path_axis_error:.4f}° along the path",
        ]
        if self.uncompensated:
            before = self.uncompensated
            lines.append(
                f"{'volumetric':<12} at the records {1e3 * before.tip_error:.1f} µm and "
                f"{3600 * before.axis_error:.1f} arcsec before compensation, {1e3 * proof.tip_error:.1f} µm and "
                f"{3600 * proof.axis_error:.1f} arcsec after it"
            )
        lines += [f"{'warning':<12} {warning}" for warning in self.warnings]
        if self.strategies:
            lines += ["", *_strategy_table(self.strategies)]
        for region, passages in self.passages.items():
            lines += ["", *passage_table(region, passages)]
        return "\n".join(lines)


def _strategy_table(strategies):
    yield f"{'selection':<14}{'cost':>10}  largest rotary steps"
    for name, cost, steps, reason in strategies:
        yield f"{name:<14}" + (reason or f"{cost:10.3f}  " + " ".join(f"{step:8.3f}°" for step in steps))


def passage_table(region, passages):
    """Lines of a table that compares the ways through a singular region."""
    yield f"singular region, records {region[0] + 1} to {region[1] + 1}"
    per = "rec" if any(passage.per_record for passage in passages) else "s"
    yield f"{'way':<14}{'peak °/' + per:>12}{'tip mm':>10}{'axis °':>9}{'blocks':>8}{'time s':>8}"
    for passage in passages:
        if passage.reason:
            yield f"{passage.name:<14}{passage.reason}"
        else:
            yield (
                f"{passage.name:<14}{np.degrees(passage.peak_rate):12.1f}{passage.tip_error:10.4f}"
                f"{np.degrees(passage.axis_error):9.4f}{passage.blocks:8d}{passage.time:8.2f}"
            )
