"""Settings of the estimation of frequency responses."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from flexros.config.settings import Settings

Average = Literal["joint", "arithmetic", "logarithmic"]
"""How blocks are combined."""

Method = Literal["auto", "periodic", "local_polynomial", "smoothing"]
"""How samples are converted to a response."""

DataWindow = Literal["boxcar", "bartlett", "hann"]
"""Weight of the samples over a record."""


class FrfSettings(Settings):
    """Settings of the estimation of frequency responses."""

    partial: bool = Field(
        False,
        description="use the complete blocks of a log that ends, or was stopped, before its plan; else it is rejected",
    )
    method: Method = Field(
        "auto",
        description="periodic: whole periods in steady state; local_polynomial: any record, transients modelled; "
        "smoothing: ratio of smoothed spectra; auto: periodic where the excitation is, else local_polynomial",
    )
    average: Average = Field(
        "joint",
        description="joint: one least-squares estimate over all blocks; arithmetic, logarithmic: mean of the blocks' "
        "responses",
    )
    reference: Literal["auto", "unknown"] = Field(
        "auto", description="auto: use the reference of the log as instrument where it has one; unknown: never"
    )
    drift_degree: Annotated[int, Field(ge=0, le=5)] = Field(
        2, description="degree of the polynomial of a slow motion that is subtracted from whole periods; 0: none"
    )
    pool_lines: Annotated[int, Field(ge=0, le=50)] = Field(
        3, description="neighbours on either side over which error covariances are pooled"
    )
    polynomial_degree: Annotated[int, Field(ge=0, le=6)] = Field(
        2, description="degree of the local polynomials of response and transient"
    )
    spare_degrees: Annotated[int, Field(ge=1, le=200)] = Field(
        4, description="degrees of freedom left for the noise in each local fit; more of them widen its band"
    )
    thinned: bool = Field(
        True, description="keep only lines of non-periodic records whose estimates are nearly independent"
    )
    rest_samples: Annotated[int, Field(ge=1)] = Field(
        1, description="samples at rest at either end of a record over which its end values are averaged"
    )
    window: DataWindow = Field("boxcar", description="weight of the samples, for smoothing")
    smoothing: Annotated[int, Field(ge=1, le=999)] = Field(
        5, description="length of the triangular window over frequency, odd, for smoothing"
    )
