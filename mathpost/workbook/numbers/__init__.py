"""Sheets of numbers without formulas: `values` reads what each should be from labels, `threes` from the numbers."""
