"""Columns in and out: pandas, polars, or plain arrays, whichever is there."""

from __future__ import annotations

from typing import Any, Mapping

import numpy as np


def frame_of(columns: Mapping[str, Any]) -> Any:
    """Columns as a pandas frame; where pandas is missing as a polars one, else as they are."""
    try:
        import pandas as pd
    except ImportError:
        try:
            import polars as pl
        except ImportError:
            return dict(columns)
        return pl.DataFrame(dict(columns))
    return pd.DataFrame(dict(columns), copy=False)


def table_of(rows: list[dict[str, Any]], names: list[str]) -> Any:
    """Rows as a frame with these columns."""
    return frame_of({name: [row.get(name) for row in rows] for name in names})


def columns_of(frame: Any) -> Any:
    """Input of the extension: an Arrow stream, or names with arrays and units."""
    stream = getattr(frame, "__arrow_c_stream__", None)
    if stream is not None:
        try:
            return stream()
        except ImportError:
            pass  # pandas without pyarrow
    try:
        names = list(frame.columns) if hasattr(frame, "columns") else list(frame.keys())
    except AttributeError:
        raise TypeError(
            "a frame is an object with __arrow_c_stream__ (pandas, polars, DuckDB, pyarrow), "
            f"or names with arrays, not {type(frame).__name__}"
        ) from None
    columns = []
    for name in names:
        array = np.asarray(frame[name])
        unit = None
        if array.dtype.kind in "mM":
            # Counted in ns; NaT becomes the smallest number, which no clock shows.
            array, unit = array.astype(f"{array.dtype.kind}8[ns]").astype(np.int64), "ns"
        elif array.dtype.kind in "iub" and array.dtype != np.uint64:
            array = array.astype(np.int64)
        elif array.dtype.kind in "fu":
            array = array.astype(np.float64)
        else:
            continue  # text is no column of a run
        if array.ndim != 1:
            raise ValueError(f"column {name} has {array.ndim} dimensions; a column has one")
        columns.append((str(name), np.ascontiguousarray(array), unit))
    if not columns:
        raise TypeError("the frame has no column of numbers")
    return columns


def floats_of(values: Any) -> np.ndarray:
    """One column of float64."""
    array = np.ascontiguousarray(np.asarray(values, dtype=np.float64))
    if array.ndim != 1:
        raise ValueError(f"{array.ndim} dimensions where a column has one")
    return array
