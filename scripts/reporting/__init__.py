# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The parts of scripts/report.py: records as a pandas table, tables in Markdown, plots by matplotlib."""

try:
    import matplotlib, pandas  # noqa: E401, F401
except ModuleNotFoundError as error:
    package = f"install the package python3-{error.name}"
    raise SystemExit(f"{error.name} is not installed for this Python: {package}") from error
