"""How far long work is."""

from __future__ import annotations

import importlib.util
import sys
import time
from contextlib import contextmanager
from typing import Any, Callable, Iterator, List, Optional, Union

Progress = Union[bool, None, Callable[[str, float], None]]
"""None: a bar where somebody can see it and tqdm is there. True, False: a bar, none. A function is called with the stage
and how far it is, 0..1; what it raises ends the work."""


_SHORT_S = 0.5
"""Work that takes less shows no bar."""


@contextmanager
def told(progress: Progress) -> Iterator[Optional[Callable[[str, float], None]]]:
    """What the compiled half is to call, if anything."""
    if callable(progress):
        yield progress
        return
    kind = _kind(progress)
    if kind is None:
        yield None
        return
    begun = time.monotonic()
    bars: List[Any] = []

    def tell(stage: str, share: float) -> None:
        if not bars and time.monotonic() - begun > _SHORT_S:
            bars.append(kind(total=100, leave=False, bar_format="{desc}: {bar} {n_fmt} %"))
        for bar in bars:
            bar.set_description_str(stage, refresh=False)
            bar.n = round(100 * min(max(share, 0.0), 1.0))
            bar.refresh()

    try:
        yield tell
    finally:
        for bar in bars:
            bar.close()


def _kind(progress: Optional[bool]):
    """The bar that can be seen, if any."""
    is_notebook = "ipykernel" in sys.modules
    # a notebook's own bar needs widgets; without them it would be a line for every news
    has_widgets = is_notebook and importlib.util.find_spec("ipywidgets") is not None
    if progress is False or not (progress or has_widgets or (not is_notebook and sys.stderr.isatty())):
        return None
    try:
        if has_widgets:
            from tqdm.notebook import tqdm
        else:
            from tqdm import tqdm
    except ImportError:
        return None
    return tqdm
