"""Words of the query of a request, checked."""

from __future__ import annotations

import math
from typing import TypeVar

from starlette.requests import Request

from propermodel.diagnostics import DocumentError, Path, parse_path
from propermodel.modelling.schema import Codec
from propermodel.studio.faults import StudioError
from propermodel.studio.orders import read_order

T = TypeVar("T")

MOST_SIGNALS = 400
MOST_INTERVALS = 10_000
_INTERVALS = 1000  # where nobody says


def asked(request: Request, name: str) -> str:
    """A word that has to be there.

    Raises:
        StudioError: it is not.
    """
    value = request.query_params.get(name, "")
    if not value:
        raise _bad(f"the request does not say '{name}'", f"ask with ?{name}=...")
    return value


def number(request: Request, name: str, otherwise: float) -> float:
    """A finite number.

    Raises:
        StudioError: it is none.
    """
    text = request.query_params.get(name, "")
    try:
        value = float(text) if text else otherwise
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _bad(f"'{name}' is '{text[:40]}', which is no number", "write it with digits, in SI")
    return value


def signals(request: Request) -> list[Path]:
    """The observables that are named, in order.

    Raises:
        StudioError: there are none, or too many.
    """
    found = request.query_params.getlist("signal")
    if not 0 < len(found) <= MOST_SIGNALS:
        raise _bad(f"{len(found)} signals are asked for", f"ask for 1 to {MOST_SIGNALS} with ?signal=...&signal=...")
    return [parse_path(text) for text in found]


def window(request: Request, start: float, stop: float) -> tuple[float, float, int]:
    """The instants between which, and the number of intervals in which, something is asked for.

    Raises:
        StudioError: they are none.
    """
    begin, end = number(request, "from", start), number(request, "to", stop)
    count = number(request, "count", _INTERVALS)
    if not end > begin:
        raise _bad(f"{begin:g} to {end:g} s is no window", "let 'from' be before 'to'")
    if count != int(count) or not 1 <= count <= MOST_INTERVALS:
        raise _bad(f"{count:g} is no number of intervals", f"give a whole number up to {MOST_INTERVALS}")
    return begin, end, int(count)


async def ordered(request: Request, codec: Codec[T]) -> T:
    """The order in the body of a request.

    Raises:
        StudioError: it is none.
    """
    try:
        return read_order(codec, await request.body())
    except DocumentError as error:
        refused = StudioError(error.diagnostics)
        refused.status = 400
        raise refused from error


def _bad(message: str, help: str) -> StudioError:
    return StudioError.with_status(400, "studio/request", message, help=help)
