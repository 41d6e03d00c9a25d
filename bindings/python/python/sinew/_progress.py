"""How far long work is."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import Callable, Iterator, Optional, Union

Progress = Union[bool, None, Callable[[str, float], None]]
"""None: a bar where somebody can see it and tqdm is there. True, False: a bar, none. A function is called with the stage
and how far it is, 0..1; what it raises ends the work."""


@contextmanager
def told(progress: Progress) -> Iterator[Optional[Callable[[str, float], None]]]:
    """What the compiled half is to call, if anything."""
    if callable(progress):
        yield progress
        return
    bar = _bar(progress)
    if bar is None:
        yield None
        return

    def tell(stage: str, share: float) -> None:
        bar.set_description_str(stage, refresh=False)
        bar.n = round(100 * min(max(share, 0.0), 1.0))
        bar.refresh()

    try:
        yield tell
    finally:
        bar.close()


def _bar(progress: Optional[bool]):
    if progress is False:
        return None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    is_seen = sys.stderr.isatty() or "ipykernel" in sys.modules
    return tqdm(total=100, unit="%", leave=False, bar_format="{desc}: {bar} {n_fmt} %") if progress or is_seen else None
