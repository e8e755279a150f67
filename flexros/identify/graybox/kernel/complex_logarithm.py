"""Logarithm of complex numbers in LLVM text: ln|z| and arg z of several lanes without branches.

Sources: logarithm of Sun fdlibm 5.3 (e_log.c, 1993); arctangent of S. L. Moshier, Cephes (atan.c, 1995), a rational
function on |t| <= 0.66 with one reduction by pi/4.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from flexros.compile.ir_text import integer_literal
from flexros.identify.graybox.kernel.complex_block import ComplexBlock, ComplexValue

if TYPE_CHECKING:
    from flexros.compile.ir_text import IrBlock

_LOG = (
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
    1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
)  # fmt: skip
_ATAN_P = (
    -6.485021904942025371773e1, -1.228866684490136173410e2, -7.500855792314704667340e1, -1.615753718733365076637e1,
    -8.750608600031904122785e-1,
)  # fmt: skip
_ATAN_Q = (
    1.945506571482613964425e2, 4.853903996359136964868e2, 4.328810604912902668951e2, 1.650270098316988542046e2,
    2.485846490142306297962e1, 1.0,
)  # fmt: skip
_MANTISSA = (1 << 52) - 1
_ONE = 0x3FF0000000000000
_SHIFTED = 0x4330000000000000  # the number 2^52, whose last bits count units


def write_logarithm(block: IrBlock, z: ComplexValue) -> ComplexValue:
    """Write ln|z| + j arg z, arg within [-pi, pi]; NaN and infinity stay what they are.

    Args:
        block: Where to write.
        z: The number; |z|^2 must neither underflow nor overflow.

    Returns:
        The logarithm.
    """
    square = ComplexBlock(block).square(z)
    return ComplexValue(block.mul(block.number(0.5), write_real_logarithm(block, square)), _angle(block, z))


def write_real_logarithm(block: IrBlock, x: str) -> str:
    """Write ln(x) of a normal positive number; return its name."""
    lanes = block.lanes
    bits = block.bits(x)
    exponent = block.value(f"lshr {block.integer} {bits}, {integer_literal(52, lanes)}")
    exponent = block.from_bits(block.value(f"or {block.integer} {exponent}, {integer_literal(_SHIFTED, lanes)}"))
    e = block.sub(exponent, block.number(2.0**52 + 1023.0))
    fraction = block.value(f"and {block.integer} {bits}, {integer_literal(_MANTISSA, lanes)}")
    m = block.from_bits(block.value(f"or {block.integer} {fraction}, {integer_literal(_ONE, lanes)}"))
    large = block.compare("ogt", m, block.number(math.sqrt(2.0)))
    m = block.select(large, block.mul(m, block.number(0.5)), m)
    e = block.select(large, block.add(e, block.number(1.0)), e)
    f = block.sub(m, block.number(1.0))
    s = block.div(f, block.add(f, block.number(2.0)))
    z = block.mul(s, s)
    half = block.mul(block.number(0.5), block.mul(f, f))
    inner = block.mul(s, block.fma(z, block.polynomial(z, _LOG), half))
    ln = block.fma(e, block.number(math.log(2.0)), block.sub(f, block.sub(half, inner)))
    return block.add(ln, block.sub(x, x))


def _angle(block: IrBlock, z: ComplexValue) -> str:
    """Write atan2(im, re)."""
    x, y = block.intrinsic("fabs", z.re), block.intrinsic("fabs", z.im)
    steep = block.compare("ogt", y, x)
    low, high = block.select(steep, x, y), block.select(steep, y, x)
    wide = block.compare("ogt", low, block.mul(high, block.number(0.66)))
    t = block.div(
        block.select(wide, block.sub(low, high), low),
        block.select(wide, block.add(low, high), high),
    )
    square = block.mul(t, t)
    share = block.div(block.polynomial(square, _ATAN_P), block.polynomial(square, _ATAN_Q))
    angle = block.fma(t, block.mul(square, share), t)
    angle = block.add(angle, block.select(wide, block.number(math.pi / 4), block.number(0.0)))
    angle = block.select(steep, block.sub(block.number(math.pi / 2), angle), angle)
    left = block.compare("olt", z.re, block.number(0.0))
    angle = block.select(left, block.sub(block.number(math.pi), angle), angle)
    return block.intrinsic("copysign", angle, z.im)
