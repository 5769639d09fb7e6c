"""The kinds of values that a manifest holds, each with the range that is accepted."""

from typing import Annotated, Final

from pydantic import ConfigDict, Field

Name = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$")]
Digest = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
Degrees = Annotated[float, Field(ge=-360, le=360)]
Elevation = Annotated[float, Field(ge=-90, le=90)]
Index = Annotated[int, Field(ge=0, le=10_000_000)]
Count = Annotated[int, Field(ge=1, le=10_000_000)]
Side = Annotated[int, Field(ge=8, le=4096)]
Magnitude = Annotated[float, Field(ge=0)]
Share = Annotated[float, Field(ge=0, le=1)]

STRICT: Final = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
