"""Sine and cosine, exponential, natural logarithm and hyperbolic tangent as LLVM code over lanes.

Fused multiply-add is used only where it is written explicitly, and is exact on every processor (in software if
necessary). All processors and all numbers of lanes therefore give the same bits.

Sources: kernels k_sin.c, k_cos.c and e_log.c of Sun fdlibm 5.3 (1993) in the ordering of FreeBSD msun; argument
reduction in three parts (Cody and Waite 1980, with a first part of 33 bits); exponential by Taylor expansion to degree
13 on |r| <= ln(2)/2. Errors, tested against decimal arithmetic: sine and cosine below 1 ulp for |x| <= SINCOS_RANGE
(beyond it the system's mathematical library is called), exponential and logarithm below 1 ulp, hyperbolic tangent
below 3 ulp.
"""

from __future__ import annotations

from math import factorial

from flexros.compile.ir_text import IrBlock, integer_literal, value_type

SINCOS_RANGE = 1.6e6  # rad: quadrant numbers below 2^20 keep the product with the 33-bit part of pi/2 exact
_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding it rounds to an integer, held in the low bits
_ROUND_BITS = 0x4338000000000000
_PI_HALF = (1.57079632673412561417e00, 6.077100506506192e-11, 3.5215598651832e-27)
_SIN = (
    -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
    2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10,
)  # fmt: skip
_COS = (
    4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
    -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11,
)  # fmt: skip
_LN2 = (6.93147180369123816490e-01, 1.90821492927058770002e-10)
_LOG = (
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
    1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
)  # fmt: skip
_ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
_SUBNORMAL = 54  # a number below the normal range is scaled by two to the power of this
_LOG2_E = 1.44269504088896338700e00

SINCOS = "sincos"
EXPONENTIAL = "exp"
LOGARITHM = "log"
TANH = "tanh"


def routine_name(routine: str, lanes: int) -> str:
    """Return the symbol of a routine (SINCOS, EXPONENTIAL, LOGARITHM, TANH) for a number of lanes."""
    return f"@flexros.{routine}.{lanes}"


def routine_text(routine: str, lanes: int) -> str:
    """Return the definition of a routine; that of sine and cosine returns the pair {sin x, cos x}.

    Args:
        routine: SINCOS, EXPONENTIAL, LOGARITHM or TANH.
        lanes: Doubles per number.
    """
    return {SINCOS: _sincos, EXPONENTIAL: _exponential, LOGARITHM: _logarithm, TANH: _tanh}[routine](lanes)


def _negative(block: IrBlock, x: str) -> str:
    return block.value(f"fneg {block.type} {x}")


def _sine_kernel(block: IrBlock, x: str, tail: str, z: str, w: str) -> str:
    r = block.fma(block.mul(z, w), block.polynomial(z, _SIN[4:]), block.polynomial(z, _SIN[1:4]))
    minus_v = _negative(block, block.mul(z, x))
    inner = block.fma(minus_v, r, block.mul(block.number(0.5), tail))
    correction = block.fma(minus_v, block.number(_SIN[0]), block.fma(z, inner, _negative(block, tail)))
    return block.sub(x, correction)


def _cosine_kernel(block: IrBlock, x: str, tail: str, z: str, w: str) -> str:
    lower = block.mul(z, block.polynomial(z, _COS[:3]))
    r = block.fma(block.mul(w, w), block.polynomial(z, _COS[3:]), lower)
    head = block.fma(block.number(-0.5), z, block.number(1.0))
    rest = block.fma(block.number(-0.5), z, block.sub(block.number(1.0), head))
    small = block.fma(z, r, _negative(block, block.mul(x, tail)))
    return block.add(head, block.add(rest, small))


def _reduce(block: IrBlock, x: str) -> tuple[str, str, str]:
    """Subtract the nearest multiple of pi/2; return remainder, its rounding error, and the quadrant in the low bits."""
    rounded = block.fma(x, block.number(6.36619772367581382433e-01), block.number(_ROUND))
    n = block.sub(rounded, block.number(_ROUND))
    minus_n = _negative(block, n)
    # the 33-bit first part makes n * pi/2 exact; the rounding errors of the next part go into the tail (Cody and Waite)
    t = block.fma(minus_n, block.number(_PI_HALF[0]), x)
    product = block.mul(n, block.number(_PI_HALF[1]))
    product_rest = block.fma(n, block.number(_PI_HALF[1]), _negative(block, product))
    r = block.sub(t, product)
    back = block.sub(r, t)
    difference_rest = block.sub(block.sub(t, block.sub(r, back)), block.add(product, back))
    tail = block.fma(minus_n, block.number(_PI_HALF[2]), block.sub(difference_rest, product_rest))
    return r, tail, block.bits(rounded)


def _flip_sign(block: IrBlock, number: str, quadrant: str) -> str:
    """Negate where bit 1 of the quadrant is set."""
    sign = block.value(f"and {block.integer} {quadrant}, {integer_literal(2, block.lanes)}")
    sign = block.value(f"shl {block.integer} {sign}, {integer_literal(62, block.lanes)}")
    return block.from_bits(block.value(f"xor {block.integer} {block.bits(number)}, {sign}"))


def _sincos(lanes: int) -> str:
    block = IrBlock(lanes)
    x, tail, quadrant = _reduce(block, "%x")
    z = block.mul(x, x)
    w = block.mul(z, z)
    sine, cosine = _sine_kernel(block, x, tail, z, w), _cosine_kernel(block, x, tail, z, w)
    odd = block.value(f"trunc {block.integer} {quadrant} to {block.mask}")
    next_quadrant = block.value(f"add {block.integer} {quadrant}, {integer_literal(1, lanes)}")
    s = _flip_sign(block, block.select(odd, cosine, sine), quadrant)
    c = _flip_sign(block, block.select(odd, sine, cosine), next_quadrant)
    # odd quadrants exchange sine and cosine; arguments out of range take the slow branch, lane by lane
    far = block.compare("ogt", block.intrinsic("fabs", "%x"), block.number(SINCOS_RANGE))
    some = far
    if lanes > 1:
        some = block.value(f"icmp ne i{lanes} {block.value(f'bitcast {block.mask} {far} to i{lanes}')}, 0")
    block.emit(f"br i1 {some}, label %slow, label %done")
    block.emit("slow:")
    far_s = block.select(far, library_call(block, "sin", "%x"), s)
    far_c = block.select(far, library_call(block, "cos", "%x"), c)
    block.emit("br label %done")
    block.emit("done:")
    s = block.value(f"phi {block.type} [ {s}, %entry ], [ {far_s}, %slow ]")
    c = block.value(f"phi {block.type} [ {c}, %entry ], [ {far_c}, %slow ]")
    pair = f"{{ {block.type}, {block.type} }}"
    half = block.value(f"insertvalue {pair} undef, {block.type} {s}, 0")
    block.emit(f"ret {pair} {block.value(f'insertvalue {pair} {half}, {block.type} {c}, 1')}")
    return _define(pair, SINCOS, block)


def _power_of_two(block: IrBlock, exponent: str) -> str:
    biased = block.value(f"add {block.integer} {exponent}, {integer_literal(1023, block.lanes)}")
    return block.from_bits(block.value(f"shl {block.integer} {biased}, {integer_literal(52, block.lanes)}"))


def _expm1_kernel(block: IrBlock, x: str) -> tuple[str, str]:
    """Return exp(r) - 1 and the integer n with x = n ln 2 + r."""
    rounded = block.fma(x, block.number(_LOG2_E), block.number(_ROUND))
    minus_n = block.sub(block.number(_ROUND), rounded)
    high = block.fma(minus_n, block.number(_LN2[0]), x)
    r = block.fma(minus_n, block.number(_LN2[1]), high)
    tail = block.fma(minus_n, block.number(_LN2[1]), block.sub(high, r))
    z = block.mul(r, r)
    even = block.polynomial(z, tuple(1.0 / factorial(k) for k in (2, 4, 6, 8, 10, 12)))
    odd = block.polynomial(z, tuple(1.0 / factorial(k) for k in (3, 5, 7, 9, 11, 13)))
    series = block.mul(z, block.fma(r, odd, even))
    exponent = block.value(f"sub {block.integer} {block.bits(rounded)}, {integer_literal(_ROUND_BITS, block.lanes)}")
    return block.add(r, block.add(tail, series)), exponent


def _clamp(block: IrBlock, x: str, low: float, high: float) -> str:
    """Limit a number; NaN stays NaN."""
    x = block.select(block.compare("olt", x, block.number(low)), block.number(low), x)
    return block.select(block.compare("ogt", x, block.number(high)), block.number(high), x)


def _exponential(lanes: int) -> str:
    block = IrBlock(lanes)
    small, exponent = _expm1_kernel(block, _clamp(block, "%x", -746.0, 710.0))
    # 2^n as 2^(n/2) twice: a single factor would overflow or lose subnormal results near the ends of the range
    half = block.value(f"ashr {block.integer} {exponent}, {integer_literal(1, lanes)}")
    rest = block.value(f"sub {block.integer} {exponent}, {half}")
    result = block.mul(block.add(block.number(1.0), small), _power_of_two(block, half))
    block.emit(f"ret {block.type} {block.mul(result, _power_of_two(block, rest))}")
    return _define(block.type, EXPONENTIAL, block)


def _logarithm(lanes: int) -> str:
    """Write log(2^k (1 + f)) = k ln 2 + log(1 + f) with 1 + f between the roots of 1/2 and of 2."""
    block = IrBlock(lanes)
    tiny = block.compare("olt", "%x", block.number(2.2250738585072014e-308))
    scaled = block.bits(block.select(tiny, block.mul("%x", block.number(2.0**_SUBNORMAL)), "%x"))
    above = block.value(f"sub {block.integer} {scaled}, {integer_literal(_ROOT_HALF_BITS, lanes)}")
    exponent = block.value(f"ashr {block.integer} {above}, {integer_literal(52, lanes)}")
    shifted = block.value(f"shl {block.integer} {exponent}, {integer_literal(52, lanes)}")
    f = block.sub(block.from_bits(block.value(f"sub {block.integer} {scaled}, {shifted}")), block.number(1.0))
    rounded = block.value(f"add {block.integer} {exponent}, {integer_literal(_ROUND_BITS, lanes)}")
    shift = block.select(tiny, block.number(_ROUND + _SUBNORMAL), block.number(_ROUND))
    k = block.sub(block.from_bits(rounded), shift)
    s = block.div(f, block.add(f, block.number(2.0)))
    z = block.mul(s, s)
    w = block.mul(z, z)
    odd, even = block.polynomial(w, _LOG[::2]), block.polynomial(w, _LOG[1::2])
    R = block.fma(w, even, block.mul(z, odd))
    half_square = block.mul(block.mul(f, f), block.number(0.5))
    tail = block.fma(s, block.add(half_square, R), block.mul(k, block.number(_LN2[1])))
    result = block.sub(block.mul(k, block.number(_LN2[0])), block.sub(block.sub(half_square, tail), f))
    result = block.select(block.compare("olt", "%x", block.number(float("inf"))), result, "%x")  # infinity and NaN
    result = block.select(block.compare("oeq", "%x", block.number(0.0)), block.number(float("-inf")), result)
    result = block.select(block.compare("olt", "%x", block.number(0.0)), block.number(float("nan")), result)
    block.emit(f"ret {block.type} {result}")
    return _define(block.type, LOGARITHM, block)


def _tanh(lanes: int) -> str:
    """Write tanh|x| = e / (e + 2) with e = exp(2|x|) - 1; the sign is copied from x."""
    block = IrBlock(lanes)
    magnitude = block.intrinsic("fabs", "%x")
    small, exponent = _expm1_kernel(block, _clamp(block, block.add(magnitude, magnitude), 0.0, 44.0))
    scale = _power_of_two(block, exponent)
    e = block.fma(small, scale, block.sub(scale, block.number(1.0)))
    result = block.div(e, block.add(e, block.number(2.0)))
    block.emit(f"ret {block.type} {block.intrinsic('copysign', result, '%x')}")
    return _define(block.type, TANH, block)


def _define(result: str, routine: str, block: IrBlock) -> str:
    head = f"define internal {result} {routine_name(routine, block.lanes)}({value_type(block.lanes)} %x) nounwind {{"
    return f"{head}\nentry:\n{block.text()}\n}}"


def library_call(block: IrBlock, name: str, *arguments: str) -> str:
    """Write the call of a function of the system's mathematical library for every lane; return the result's name."""
    if block.lanes == 1:
        return block.value(f"call double @{name}({', '.join(f'double {a}' for a in arguments)})")
    result = "undef"
    for lane in range(block.lanes):
        scalars = [block.value(f"extractelement {block.type} {a}, i32 {lane}") for a in arguments]
        value = block.value(f"call double @{name}({', '.join(f'double {s}' for s in scalars)})")
        result = block.value(f"insertelement {block.type} {result}, double {value}, i32 {lane}")
    return result
