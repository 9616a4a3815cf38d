"""Tests run side by side: one that spread its small matrices over all processors would wait for the others."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
