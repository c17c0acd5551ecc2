# pyright: basic
"""Prints elementary functions without branches, for any number of lanes.

LLVM does not vectorise calls of the system's library, and libraries differ. These are accurate to four units in the
last place and give the same bits on every system. Methods and coefficients: fdlibm (Sun Microsystems, 1993) for
log, sin, cos; Cephes (Moshier, 1989) for exp and atan.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence

from propermodel.codegen.llvm_text import Module, Shape, Text

_LARGEST = 1.7976931348623157e308
# Adding it leaves the nearest whole number in the low bits.
_ROUNDER = 1.5 * 2.0**52
_LN2 = (6.93145751953125e-1, 1.42860682030941723212e-6)  # high part with few bits, and the rest
_LN2_LONG = (6.93147180369123816490e-01, 1.90821492927058770002e-10)


def call_math(text: Text, name: str, *arguments: str) -> str:
    """The result of exp, log, sin, cos, tanh or atan2."""
    return _call(text, name, _FUNCTIONS[name], arguments)


def call_power(text: Text, base: str, exponent: float) -> str:
    """The power of a number with a constant exponent that is not a small whole or half number."""
    if exponent == int(exponent):
        return text.intrinsic("pow", base, text.constant(exponent))
    return _call(text, f"pow.{_bits_of(exponent):016x}", lambda t, x: _power(t, x, exponent), [base])


def _call(text: Text, name: str, body: Callable[..., str], arguments: Sequence[str]) -> str:
    full = f"math.{name}.{text.shape.suffix}"
    if full not in text.module.declared:
        text.module.declare(full, "")  # functions used by this one are declared before it
        text.module.declare(full, _define(text.module, text.shape, full, body, len(arguments)))
    passed = ", ".join(f"{text.kind} {argument}" for argument in arguments)
    return text.emit(f"call {text.kind} @{full}({passed})")


def _define(module: Module, shape: Shape, name: str, body: Callable[..., str], count: int) -> str:
    text = Text(module, shape)
    parameters = [f"%x{i}" for i in range(count)]
    result = body(_Bits(text), *parameters)
    signature = ", ".join(f"{shape.number} {parameter}" for parameter in parameters)
    head = f"define internal {shape.number} @{name}({signature}) nounwind {{"
    return "\n".join([head, *text.lines, f"  ret {shape.number} {result}", "}"])


class _Bits:
    """Arithmetic on numbers and on their bits."""

    def __init__(self, text: Text) -> None:
        self.text = text
        lanes = text.shape.lanes
        self.whole = "i64" if lanes == 1 else f"<{lanes} x i64>"
        self.add, self.subtract = text.add, text.subtract
        self.multiply, self.divide = text.multiply, text.divide
        self.choose, self.compare, self.size = text.choose, text.compare, text.size
        self.constant = text.constant

    def scaled(self, a: str, factor: float) -> str:
        return self.multiply(a, self.constant(factor))

    def plus(self, a: str, constant: float) -> str:
        return self.add(a, self.constant(constant))

    def polynomial(self, x: str, coefficients: Sequence[float]) -> str:
        """The polynomial whose highest coefficient comes first."""
        result = self.constant(coefficients[0])
        for coefficient in coefficients[1:]:
            result = self.plus(self.multiply(result, x), coefficient)
        return result

    def whole_constant(self, value: int) -> str:
        lanes = self.text.shape.lanes
        return str(value) if lanes == 1 else "<" + ", ".join(f"i64 {value}" for _ in range(lanes)) + ">"

    def bits(self, a: str) -> str:
        return self.text.emit(f"bitcast {self.text.kind} {a} to {self.whole}")

    def number(self, bits: str) -> str:
        return self.text.emit(f"bitcast {self.whole} {bits} to {self.text.kind}")

    def on_bits(self, operation: str, a: str, constant: int) -> str:
        return self.text.emit(f"{operation} {self.whole} {a}, {self.whole_constant(constant)}")

    def has_bit(self, bits: str, mask: int) -> str:
        part = self.on_bits("and", bits, mask)
        return self.text.emit(f"icmp ne {self.whole} {part}, {self.whole_constant(0)}")

    def clipped(self, x: str, low: float, high: float) -> str:
        """The number held within limits; not-a-number stays."""
        for test, limit in (("olt", low), ("ogt", high)):
            x = self.choose(self.compare(test, x, self.constant(limit)), self.constant(limit), x)
        return x

    def with_sign_of(self, size: str, signed: str) -> str:
        return self.text.intrinsic("copysign", size, signed)

    def nearest(self, x: str) -> tuple[str, str]:
        """The nearest whole number, as a number and as bits whose low part it is."""
        shifted = self.plus(x, _ROUNDER)
        return self.plus(shifted, -_ROUNDER), self.bits(shifted)

    def two_to(self, bits: str) -> str:
        """Two to the power in the low part of the bits, which must be within +-1022."""
        return self.number(self.on_bits("shl", self.on_bits("add", bits, 1023), 52))


_EXP_P = (1.26177193074810590878e-4, 3.02994407707441961300e-2, 9.99999999999999999910e-1)
_EXP_Q = (3.00198505138664455042e-6, 2.52448340349684104192e-3, 2.27265548208155028766e-1, 2.0)


def _exp_parts(b: _Bits, x: str, rest: str | None = None) -> tuple[str, str, str]:
    """The bits of k, and p and q, with exp(x + rest) = 2**k (q + p) / (q - p)."""
    k, bits = b.nearest(b.scaled(x, 1.0 / math.log(2.0)))
    r = b.subtract(b.subtract(x, b.scaled(k, _LN2[0])), b.scaled(k, _LN2[1]))
    if rest is not None:
        r = b.add(r, rest)
    square = b.multiply(r, r)
    return bits, b.multiply(r, b.polynomial(square, _EXP_P)), b.polynomial(square, _EXP_Q)


def _exp_scaled(b: _Bits, bits: str, p: str, q: str) -> str:
    fraction = b.plus(b.scaled(b.divide(p, b.subtract(q, p)), 2.0), 1.0)
    # In two factors, so that results near both ends of the range are reached; the bits hold k in their low part.
    low = b.on_bits("ashr", b.on_bits("shl", bits, 32), 32)
    half = b.on_bits("ashr", low, 1)
    other = b.text.emit(f"sub {b.whole} {low}, {half}")
    return b.multiply(b.multiply(fraction, b.two_to(half)), b.two_to(other))


def _exp(b: _Bits, x: str) -> str:
    return _exp_scaled(b, *_exp_parts(b, b.clipped(x, -746.0, 710.0)))


def _tanh(b: _Bits, x: str) -> str:
    # (e**2x - 1) / (e**2x + 1) from the parts of the exponential: no cancellation near zero, one division.
    size = b.clipped(b.size(x), 0.0, 20.0)
    bits, p, q = _exp_parts(b, b.add(size, size))
    scale = b.two_to(b.on_bits("and", bits, 0xFF))
    above, below = b.add(q, p), b.subtract(q, p)
    less, more = b.plus(scale, -1.0), b.plus(scale, 1.0)
    numerator = b.add(b.multiply(less, q), b.multiply(more, p))
    return b.with_sign_of(b.divide(numerator, b.add(b.multiply(scale, above), below)), x)


_LOG_EVEN = (1.531383769920937332e-01, 2.222219843214978396e-01, 3.999999999940941908e-01)
_LOG_ODD = (
    1.479819860511658591e-01,
    1.818357216161805012e-01,
    2.857142874366239149e-01,
    6.666666666666735130e-01,
)


def _log_parts(b: _Bits, x: str) -> tuple[str, str, str, str]:
    """With x = 2**k (1 + f): k, f, f**2 / 2 and the correction c, so that log(1 + f) = f - (f**2 / 2 - c)."""
    is_small = b.compare("olt", x, b.constant(2.0**-1022))
    scaled = b.choose(is_small, b.scaled(x, 2.0**54), x)
    # Move the interval of the fraction from [1, 2) to [sqrt(1/2), sqrt(2)).
    moved = b.on_bits("add", b.bits(scaled), 0x3FF0000000000000 - 0x3FE6A09E00000000)
    exponent = b.on_bits("lshr", moved, 52)
    k = b.plus(b.number(b.on_bits("or", exponent, 0x4330000000000000)), -(2.0**52) - 1023.0)
    k = b.choose(is_small, b.plus(k, -54.0), k)
    fraction = b.number(b.on_bits("add", b.on_bits("and", moved, 0x000FFFFFFFFFFFFF), 0x3FE6A09E00000000))
    f = b.plus(fraction, -1.0)
    s = b.divide(f, b.plus(f, 2.0))
    z = b.multiply(s, s)
    w = b.multiply(z, z)
    series = b.add(b.multiply(w, b.polynomial(w, _LOG_EVEN)), b.multiply(z, b.polynomial(w, _LOG_ODD)))
    half_square = b.multiply(b.scaled(f, 0.5), f)
    return k, f, half_square, b.multiply(s, b.add(half_square, series))


def _log(b: _Bits, x: str) -> str:
    k, f, half_square, c = _log_parts(b, x)
    low = b.add(c, b.scaled(k, _LN2_LONG[1]))
    result = b.subtract(b.scaled(k, _LN2_LONG[0]), b.subtract(b.subtract(half_square, low), f))
    return _log_ends(b, x, result)


def _log_ends(b: _Bits, x: str, result: str) -> str:
    zero, infinity = b.constant(0.0), b.constant(math.inf)
    result = b.choose(b.compare("olt", x, infinity), result, x)
    result = b.choose(b.compare("oeq", x, zero), b.constant(-math.inf), result)
    return b.choose(b.compare("olt", x, zero), b.constant(math.nan), result)


_UPPER = 0xFFFFFFFFF8000000  # the bits of a number that leave room for exact products


def _bits_of(value: float) -> int:
    return struct.unpack("<Q", struct.pack("<d", value))[0]


def _number_of(bits: int) -> float:
    return struct.unpack("<d", struct.pack("<Q", bits))[0]


def _power(b: _Bits, x: str, exponent: float) -> str:
    """The exponential of the exponent times the logarithm, whose leading product is exact."""
    k, f, half_square, c = _log_parts(b, x)

    def upper(a: str) -> str:
        return b.number(b.on_bits("and", b.bits(a), _UPPER))

    # log x = head + tail, with few bits in the head.
    near = b.subtract(f, b.subtract(half_square, c))
    lost = b.subtract(b.subtract(f, near), b.subtract(half_square, c))
    whole = b.scaled(k, _LN2_LONG[0])
    total = b.add(whole, near)
    head = upper(total)
    tail = b.add(b.add(b.subtract(whole, head), near), b.add(lost, b.scaled(k, _LN2_LONG[1])))
    exponent_head = _number_of(_bits_of(exponent) & _UPPER)
    leading = b.scaled(head, exponent_head)
    rest = b.add(b.scaled(head, exponent - exponent_head), b.scaled(tail, exponent))
    result = _exp_scaled(b, *_exp_parts(b, b.clipped(leading, -746.0, 710.0), rest))
    zero, infinity = b.constant(0.0), b.constant(math.inf)
    at_zero, at_infinity = (0.0, math.inf) if exponent > 0.0 else (math.inf, 0.0)
    result = b.choose(b.compare("oeq", x, zero), b.constant(at_zero), result)
    result = b.choose(b.compare("oeq", x, infinity), b.constant(at_infinity), result)
    return b.choose(b.compare("oge", x, zero), result, b.constant(math.nan))


# The half turn's half in three parts; products of the first two with whole numbers below 2**20 are exact.
_QUARTER = (1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
_MOST_REDUCED = 1.0e6
_SIN = (
    1.58969099521155010221e-10,
    -2.50507602534068634195e-08,
    2.75573137070700676789e-06,
    -1.98412698298579493134e-04,
    8.33333333332248946124e-03,
)
_SIN_FIRST = -1.66666666666666324348e-01
_COS = (
    -1.13596475577881948265e-11,
    2.08757232129817482790e-09,
    -2.75573143513906633035e-07,
    2.48015872894767294178e-05,
    -1.38888888888741095749e-03,
    4.16666666666666019037e-02,
)


def _sine(b: _Bits, x: str, quarter: int) -> str:
    """The sine of x plus so many quarter turns; far from zero that of the system's library."""
    n, bits = b.nearest(b.scaled(x, 2.0 / math.pi))
    r = b.subtract(x, b.scaled(n, _QUARTER[0]))
    product = b.scaled(n, _QUARTER[1])
    nearer = b.subtract(r, product)
    lost = b.subtract(b.scaled(n, _QUARTER[2]), b.subtract(b.subtract(r, nearer), product))
    y = b.subtract(nearer, lost)
    rest = b.subtract(b.subtract(nearer, y), lost)
    z = b.multiply(y, y)
    cube = b.multiply(z, y)
    inner = b.subtract(b.scaled(rest, 0.5), b.multiply(cube, b.polynomial(z, _SIN)))
    inner = b.subtract(b.multiply(z, inner), rest)
    sine = b.subtract(y, b.subtract(inner, b.scaled(cube, _SIN_FIRST)))
    half = b.scaled(z, 0.5)
    near_one = b.subtract(b.constant(1.0), half)
    lost = b.subtract(b.subtract(b.constant(1.0), near_one), half)
    series = b.multiply(z, b.multiply(z, b.polynomial(z, _COS)))
    cosine = b.add(near_one, b.add(lost, b.subtract(series, b.multiply(y, rest))))
    turned = b.on_bits("add", bits, quarter)
    result = b.choose(b.has_bit(turned, 1), cosine, sine)
    result = b.choose(b.has_bit(turned, 2), b.text.emit(f"fneg {b.text.kind} {result}"), result)
    return _near_or_library(b, x, result, "cos" if quarter else "sin")


def _near_or_library(b: _Bits, x: str, near: str, name: str) -> str:
    text = b.text
    is_far = text.opposite(b.compare("ole", b.size(x), b.constant(_MOST_REDUCED)))
    text.do(f"br i1 {text.any(is_far)}, label %far, label %near")
    text.label("far")
    library = text.intrinsic(name, x)
    text.do(f"ret {text.kind} {b.choose(is_far, library, near)}")
    text.label("near")
    return near


_ATAN_P = (
    -8.750608600031904122785e-1,
    -1.615753718733365076637e1,
    -7.500855792314704667340e1,
    -1.228866684490136173410e2,
    -6.485021904942025371773e1,
)
_ATAN_Q = (
    1.0,
    2.485846490142306297962e1,
    1.650270098316988542046e2,
    4.328810604912902668951e2,
    4.853903996359136964868e2,
    1.945506571482613964425e2,
)
_MORE_BITS = 6.123233995736765886130e-17  # pi/2 minus its float64


def _atan2(b: _Bits, y: str, x: str) -> str:
    width, height = (b.clipped(b.size(item), 0.0, _LARGEST) for item in (x, y))
    is_steep = b.compare("ogt", height, width)
    short, long = b.choose(is_steep, width, height), b.choose(is_steep, height, width)
    is_wide = b.compare("ogt", short, b.scaled(long, 0.66))
    numerator = b.choose(is_wide, b.subtract(short, long), short)
    denominator = b.choose(is_wide, b.add(short, long), long)
    is_nothing = b.compare("oeq", denominator, b.constant(0.0))
    t = b.divide(numerator, b.choose(is_nothing, b.constant(1.0), denominator))
    z = b.multiply(t, t)
    ratio = b.divide(b.polynomial(z, _ATAN_P), b.polynomial(z, _ATAN_Q))
    angle = b.add(b.multiply(b.multiply(z, ratio), t), t)
    angle = b.choose(is_wide, b.plus(b.plus(angle, 0.5 * _MORE_BITS), math.pi / 4.0), angle)
    steep = b.subtract(b.constant(math.pi / 2.0), b.plus(angle, -_MORE_BITS))
    angle = b.choose(is_steep, steep, angle)
    is_left = b.text.emit(f"icmp slt {b.whole} {b.bits(x)}, {b.whole_constant(0)}")
    left = b.subtract(b.constant(math.pi), b.plus(angle, -2.0 * _MORE_BITS))
    angle = b.with_sign_of(b.choose(is_left, left, angle), y)
    # A sum with both keeps what is not a number.
    is_number = b.compare("ord", x, y)
    return b.choose(is_number, angle, b.add(x, y))


_FUNCTIONS: dict[str, Callable[..., str]] = {
    "exp": _exp,
    "log": _log,
    "sin": lambda b, x: _sine(b, x, 0),
    "cos": lambda b, x: _sine(b, x, 1),
    "tanh": _tanh,
    "atan2": _atan2,
}
