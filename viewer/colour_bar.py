"""Ticks of the colour bar and names of categories, the same in the window and in pictures."""

import math


def ticks(low: float, high: float, wanted: int = 5) -> list[float]:
    """About `wanted` round values within [low, high], ascending."""
    if not (math.isfinite(low) and math.isfinite(high) and high > low):
        return []
    raw = (high - low) / max(wanted - 1, 1)
    power = 10.0 ** math.floor(math.log10(raw))
    step = min((1.0, 2.0, 2.5, 5.0, 10.0), key=lambda m: abs(m * power - raw)) * power
    first = math.ceil(low / step - 1e-6)
    last = math.floor(high / step + 1e-6)
    return [i * step + 0.0 for i in range(first, last + 1)]


def tick_text(value: float, step: float) -> str:
    """A tick's value with the decimals that its step needs; powers of ten beyond five digits."""
    if value != 0.0 and (abs(value) >= 1e5 or step < 1e-4):
        return f"{value:.1e}".replace("e+0", "e").replace("e-0", "e-")
    decimals = max(0, -math.floor(math.log10(step) + 1e-9)) if step > 0.0 else 0
    if decimals and abs(step * 10**decimals - round(step * 10**decimals)) > 1e-6:
        decimals += 1  # steps of 0.25
    elif not decimals and abs(step - round(step)) > 1e-6:
        decimals = 1  # steps of 2.5
    return f"{value:.{decimals}f}".replace("-", "\N{MINUS SIGN}")


def labelled_ticks(low: float, high: float, wanted: int = 5) -> list[tuple[float, str]]:
    """Ticks as (position along the bar in [0, 1], text)."""
    values = ticks(low, high, wanted)
    step = values[1] - values[0] if len(values) > 1 else high - low
    return [((v - low) / (high - low), tick_text(v, step)) for v in values]


def listed(names: tuple[str, ...], room: int) -> list[str]:
    """The names, or as many as there is room for and a line that counts the rest."""
    if len(names) <= room:
        return list(names)
    shown = max(room - 1, 0)
    return [*names[:shown], f"and {len(names) - shown} more"]
