"""Numbers and units as text, the same in terminal, plots and reports."""

import math
import re

# Values below this, in SI units, are rounding errors of any metric.
ROUNDING = 1e-8

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number_text(value: float, unit: str = "", *, scale: float = 0.0) -> str:
    """Returns a number with up to four digits, as "0.123" or "1.2e-07".

    Rounding errors are 0, whole numbers without unit have no decimals, and NaN
    is "-". With the `scale` of several numbers, all have as many decimals.
    """
    if math.isnan(value):
        return "-"
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    size = max(abs(value), scale)
    if abs(value) < ROUNDING:
        return "0"
    if unit == "-" and float(value).is_integer():
        return f"{value:.0f}"
    if unit == "%":
        return f"{value:.1f}"
    if not 1e-3 <= size < 1e5:
        return f"{value:.1e}"
    digits = 3 if size < 1 else 2 if size < 100 else 1 if size < 1000 else 0
    text = f"{value:.{digits}f}"
    # A number that rounds to zero has no sign.
    return text.removeprefix("-") if float(text) == 0 else text


def superscript(text: str) -> str:
    """Returns a whole number in superscript."""
    return text.translate(_SUPERSCRIPTS)


def unit_text(unit: str) -> str:
    """Returns a unit for display, such as "m/s²"; "" for "-"."""
    if unit == "-":
        return ""
    return re.sub(r"\^(-?\d+)", lambda match: superscript(match[1]), unit)


def label_text(name: str, unit: str) -> str:
    """Returns a name with its unit in brackets, if it has one."""
    shown = unit_text(unit)
    return f"{name} ({shown})" if shown else name
