"""Evaluation protocols: selection of the pedestrians that count in the detection measures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any, Final

from nvcore.common.errors import ParameterError

OCCLUSION_WORDS: Final = ("none", "partial", "heavy")
"""Levels of occlusion in words."""

OWN: Final = "own filters"
"""Name of a protocol that is not one of `PROTOCOLS`."""

MOST_NAMED: Final = 12
"""Most recordings that the description lists one by one."""

Range = tuple[float, float]


@dataclass(frozen=True)
class Protocol:
    """Selection of pedestrians and recordings. Every filter is optional.

    A pedestrian excluded by a filter is ignored: it is not a miss, and detecting it is not a false
    positive.

    Attributes
    ----------
    name, text
        Name, and description in one sentence.
    height_px
        Smallest and largest box height, both included, in pixels of the recording's own picture.
        The named protocols follow Caltech and KAIST, whose pictures are 480 and 512 px high. In
        other pictures the same number means another distance.
    occlusion
        Levels that count (0 none, 1 partial, 2 heavy). A box of unknown level counts if 0 does.
    border_px
        Margins left, top, right, bottom inside which the whole box must lie, px; None: anywhere.
    aspect
        Lowest and highest ratio of height to width, both included.
    tags
        Tags that a recording must all have; (): every recording counts.
    recordings
        Names of the recordings that count, among those with the tags; (): all.
    expand
        Detections lower than the lowest height divided by this, or higher than the highest times
        this, are removed before matching (expanded filtering, Dollár et al. 2012, section 3.3);
        None: all detections are matched.

    Raises
    ------
    ParameterError
        If a value is outside its range.

    References
    ----------
    P. Dollár, C. Wojek, B. Schiele, P. Perona: Pedestrian detection: an evaluation of the state
    of the art, PAMI 2012. S. Hwang et al.: Multispectral pedestrian detection, CVPR 2015.
    """

    name: str
    text: str = ""
    height_px: Range = (0.0, math.inf)
    occlusion: tuple[int, ...] = (0, 1, 2)
    border_px: tuple[float, float, float, float] | None = None
    aspect: Range = (0.0, math.inf)
    tags: tuple[str, ...] = ()
    recordings: tuple[str, ...] = ()
    expand: float | None = None

    def __post_init__(self) -> None:
        for name in ("height_px", "aspect", "border_px"):  # written the same after it was read
            numbers = getattr(self, name)
            if numbers is not None:
                object.__setattr__(self, name, tuple(map(float, numbers)))
        for name in ("tags", "recordings"):  # a single one may stand by itself
            if isinstance(getattr(self, name), str):
                object.__setattr__(self, name, (getattr(self, name),))
        for name in ("height_px", "aspect"):
            low, high = getattr(self, name)
            if not 0 <= low <= high or low == math.inf:
                raise ParameterError(
                    f"{name}: expected 0 <= lowest <= highest, got {low:g} and {high:g}"
                )
        if not self.occlusion or not set(self.occlusion) <= {0, 1, 2}:
            raise ParameterError(
                "occlusion: expected one or more of 0, 1, 2, got "
                + (", ".join(map(str, self.occlusion)) or "none")
            )
        if self.border_px is not None and not all(0 <= side < math.inf for side in self.border_px):
            raise ParameterError(f"border_px: expected four margins, got {self.border_px!r}")
        if self.expand is not None and not 1 <= self.expand < math.inf:
            raise ParameterError(f"expand: expected 1 or more, got {self.expand:g}")

    @property
    def title(self) -> str:
        """Name and required recordings, such as ``reasonable, night``."""
        n = len(self.recordings)
        recordings_part = self.recordings if n < 2 else (f"{n} recordings",)
        return ", ".join((self.name, *self.tags, *recordings_part))

    @property
    def filters(self) -> tuple[str, ...]:
        """Descriptions of the filters, empty if all counts that the ground truth does not flag."""
        parts = []
        if self.height_px != (0, math.inf):
            parts.append(f"height {_range(self.height_px)} px")
        if set(self.occlusion) != {0, 1, 2}:
            parts.append("occlusion " + " or ".join(OCCLUSION_WORDS[i] for i in self.occlusion))
        if self.border_px is not None:
            sides = self.border_px
            margins = (
                f"{sides[0]:g} px"
                if len(set(sides)) == 1
                else ", ".join(f"{side:g}" for side in sides) + " px (left, top, right, bottom)"
            )
            parts.append(f"whole box at least {margins} inside the picture")
        if self.aspect != (0, math.inf):
            parts.append(f"height / width {_range(self.aspect)}")
        if self.tags:
            parts.append("recordings tagged " + " and ".join(self.tags))
        if self.recordings:
            parts.append(_only(self.recordings))
        if self.expand is not None and self.height_px != (0, math.inf):
            low, high = self.height_px
            parts.append(f"detections {_range((low / self.expand, high * self.expand))} px high")
        return tuple(parts)

    def given(self) -> dict[str, object]:
        """Return the entries of a session file: name and recordings, or else all filters."""
        start = PROTOCOLS.get(self.name, PROTOCOLS["all"])
        if _of_recordings(start, self) == self:
            name: dict[str, object] = {} if self.name == "all" else {"name": self.name}
            return name | {
                key: list(value) for key in OF_RECORDINGS if (value := getattr(self, key))
            }
        return {
            key: list(value) if isinstance(value, tuple) else value
            for key in FILTERS
            if (value := getattr(self, key)) != getattr(PROTOCOLS["all"], key)
        }


FILTERS: Final = tuple(spec.name for spec in fields(Protocol) if spec.name not in ("name", "text"))
"""Names of the filters in a session file."""

OF_RECORDINGS: Final = ("tags", "recordings")
"""Filters that select recordings, with which a named protocol keeps its name."""


def protocol_from(values: Mapping[str, object]) -> Protocol:
    """Create a protocol from a mapping, such as a session file's ``[protocol]``.

    Parameters
    ----------
    values
        ``name``, one of `PROTOCOLS`, and filters by name, which replace the protocol's. Without a
        name they are added to ``all``. With filters other than `OF_RECORDINGS` the name becomes
        `OWN`.

    Raises
    ------
    ParameterError
        If a name is unknown or a filter cannot have this value.
    """
    for key in values:
        if key != "name" and key not in FILTERS:
            raise ParameterError(
                f"there is no filter {key!r}; the keys are {', '.join(('name', *FILTERS))}"
            )
    start = protocol_named(values.get("name", "all"))
    filters: dict[str, Any] = {
        key: _value(key, value) for key, value in values.items() if key != "name"
    }
    protocol = replace(start, **filters)
    if protocol == _of_recordings(start, protocol):
        return protocol
    return replace(protocol, name=OWN, text="")


def _of_recordings(protocol: Protocol, other: Protocol) -> Protocol:
    """Return a protocol with the recordings of another."""
    return replace(protocol, tags=other.tags, recordings=other.recordings)


def protocol_named(name: object) -> Protocol:
    """Return the protocol with this name.

    Raises
    ------
    ParameterError
        If there is none.
    """
    if not isinstance(name, str) or name not in PROTOCOLS:
        raise ParameterError(f"there is no protocol {name!r}; there are: {', '.join(PROTOCOLS)}")
    return PROTOCOLS[name]


def _value(key: str, value: object) -> object:
    """Convert the value of a filter to the type that `Protocol` has."""
    kind, expected, lengths = {
        "height_px": (float, "two numbers, such as [50, inf]", (2,)),
        "aspect": (float, "two numbers, such as [1, inf]", (2,)),
        "border_px": (float, "four numbers: left, top, right, bottom", (4,)),
        "occlusion": (int, "levels, such as [0, 1]", (1, 2, 3)),
        "tags": (str, "a list of words", range(1, 1000)),
        "recordings": (str, "a list of names", range(1, 100_000)),
        "expand": (float, "a number", ()),
    }[key]
    items = value if isinstance(value, list) else [value]
    of_kind = (int, float) if kind is float else (kind,)
    is_list = isinstance(value, list)
    if (
        is_list != bool(lengths)
        or (is_list and len(items) not in lengths)
        or not all(isinstance(item, of_kind) and not isinstance(item, bool) for item in items)
    ):
        raise ParameterError(f"{key}: expected {expected}, got {value!r}")
    try:
        converted = tuple(kind(item) for item in items)
    except OverflowError as error:  # a whole number of hundreds of digits
        raise ParameterError(f"{key}: expected {expected}, got too large a number") from error
    return converted if is_list else converted[0]


def _only(recordings: tuple[str, ...]) -> str:
    if len(recordings) == 1:
        return f"only recording {recordings[0]}"
    if len(recordings) <= MOST_NAMED:
        return "only recordings " + ", ".join(recordings)
    return f"only {len(recordings)} recordings, from {recordings[0]} to {recordings[-1]}"


def _range(limits: Range) -> str:
    low, high = limits
    if high == math.inf:
        return f"{low:g} or more"
    return f"{high:g} or less" if low == 0 else f"{low:g} to {high:g}"


_CALTECH: Final = Protocol(
    "reasonable",
    "{Many} of 50 px or more that are at most partly occluded, as on Caltech.",
    height_px=(50, math.inf),
    occlusion=(0, 1),
    border_px=(5, 5, 5, 5),
    expand=1.25,
)

_PROTOCOLS: Final = (
    Protocol("all", "Every {one} that the ground truth does not flag as ignored."),
    _CALTECH,
    replace(
        _CALTECH,
        name="near",
        text="Unoccluded {many} of 80 px or more, as on Caltech.",
        height_px=(80, math.inf),
        occlusion=(0,),
    ),
    replace(
        _CALTECH,
        name="medium",
        text="Unoccluded {many} of 30 to 80 px, as on Caltech.",
        height_px=(30, 80),
        occlusion=(0,),
    ),
    replace(
        _CALTECH,
        name="far",
        text="Unoccluded {many} of 20 to 30 px, as on Caltech.",
        height_px=(20, 30),
        occlusion=(0,),
    ),
    replace(
        _CALTECH,
        name="occlusion",
        occlusion=(1, 2),
        text="Partly or heavily occluded {many} of 50 px or more.",
    ),
    Protocol(
        "kaist-reasonable",
        "{Many} of 55 px or more, at most partly occluded, not at the border: KAIST.",
        height_px=(55, math.inf),
        occlusion=(0, 1),
        border_px=(5, 5, 5, 5),
    ),
)

PROTOCOLS: Final[Mapping[str, Protocol]] = MappingProxyType(
    {protocol.name: protocol for protocol in _PROTOCOLS}
)
"""Named protocols. Their heights are pixels of pictures 480 (Caltech) or 512 px (KAIST) high.

The border rule of both is x 5..635 in pictures 640 px wide, y 5..475 and 5..507."""
