"""The ten recordings: people with their paths and clothes, and the cars and lamps they pass."""

from __future__ import annotations

from typing import Final

from tools.sample.places import COUNTRY, TOWN, country_things, town_things
from tools.sample.scene import Car, Climate, Person, Recording, Road, Thing

WINTER: Final = Climate()
FROST: Final = Climate(road=66, grass=48, sky=12, haze=54, things=68, skin=240)
AUTUMN: Final = Climate(road=92, grass=74, sky=30, haze=80, things=92, skin=232)
SUMMER: Final = Climate(road=134, grass=108, sky=62, haze=106, things=122, skin=190, contrast=0.40)


def _along(x: float, z: float, speed: float) -> tuple[tuple[float, float, float], ...]:
    """Return a straight walk along the road. `speed` is negative towards the car."""
    return ((0.0, x, z), (15.0, x, z + 15 * speed))


def _across(
    z: float, start_s: float, x0: float, x1: float, speed: float
) -> tuple[tuple[float, float, float], ...]:
    """Return a path that stays at x0, crosses to x1 from `start_s` on, and stays there."""
    end_s = start_s + abs(x1 - x0) / speed
    return ((0.0, x0, z), (start_s, x0, z), (end_s, x1, z + 0.3), (end_s + 20, x1, z + 0.3))


def all_recordings() -> tuple[Recording, ...]:
    """Return all recordings of the sample data, in the order of the session file."""
    return (
        _urban_crossing(),
        _urban_sidewalk(),
        _urban_groups(),
        _rural_road(),
        _rural_child(),
        _rural_cyclist(),
        _odd_pose(),
        _summer_night(),
        _oncoming_glare(),
        _winter_frost(),
    )


def _urban_crossing() -> Recording:
    return Recording(
        name="urban_crossing",
        text="Town, 8 m/s, stop at a zebra crossing; people cross from both sides",
        speed=((0, 8), (4.5, 8), (8, 0), (12.2, 0), (15, 5)),
        road=Road(**{**TOWN.__dict__, "zebras": (70.5,)}),
        climate=WINTER,
        tags=("urban", "winter"),
        people=(
            Person(_across(70, 4.6, 4.6, -7.6, 1.35), 1.78, warmth=0.8, reflectance=0.45),
            Person(_across(71, 5.2, -7.2, 4.8, 1.25), 1.66, warmth=0.7, reflectance=0.6),
            Person(_along(5.2, 60, -1.2), 1.82, warmth=0.6, reflectance=0.12),
            Person(_across(69.6, 8.6, 4.9, -7.2, 1.2), 1.72, warmth=0.35, reflectance=0.35),
            Person(_across(152, 6.5, -8, 5, 1.3), 1.74, warmth=0.8),
        ),
        cars=(
            Car(2.8, 27, heat=0.15),
            Car(-6.2, 33, heat=0.9, oncoming=True),
            Car(-6.2, 48, heat=0.1, oncoming=True),
            Car(2.8, 88, heat=0.2),
        ),
        things=(
            *town_things(1),
            Thing("sign", 3.5, 67.5, 2.7, 0.6),
            Thing("sign", -6.9, 72.5, 2.7, 0.6),
            Thing("cabinet", 6.9, 40, 1.3, 0.8, 0.4, heat=0.45),
        ),
    )


def _urban_sidewalk() -> Recording:
    return Recording(
        name="urban_sidewalk",
        text="Town, 8 m/s, people walk on both pavements behind parked cars",
        speed=((0, 8), (15, 8)),
        road=TOWN,
        climate=WINTER,
        tags=("urban", "winter"),
        horizon=234.0,
        people=(
            Person(_along(4.8, 38, 1.3), 1.80, warmth=0.8, reflectance=0.6, facing_deg=0),
            Person(_along(5.4, 96, -1.2), 1.65, warmth=0.7, reflectance=0.5),
            Person(_along(-8.0, 62, -1.4), 1.76, warmth=0.8, reflectance=0.08),
            Person(_along(4.6, 112, 0.9), 1.70, warmth=0.75, reflectance=0.35, facing_deg=0),
            Person(_along(-2.5, 205, 0.8), 1.77, warmth=0.8, facing_deg=0),
        ),
        cars=(
            Car(2.85, 43, heat=0.1),
            Car(-6.2, 38, heat=0.85, oncoming=True),
            Car(-6.2, 62, heat=0.1, oncoming=True),
            Car(2.85, 88, heat=0.5),
            Car(-6.2, 96, heat=0.2, oncoming=True, height_m=1.9, length_m=5.0),
        ),
        things=(
            *town_things(2),
            Thing("cabinet", 6.6, 71, 1.5, 0.9, 0.5, heat=0.95, tempt=0.1),
            Thing("sign", 3.6, 85, 2.6, 0.6, tempt=-0.7),
        ),
    )


def _urban_groups() -> Recording:
    return Recording(
        name="urban_groups",
        text="Town, 7 m/s slowing to 4, groups of two to four walk together and hide each other",
        speed=((0, 7), (5, 7), (8, 4), (15, 4.5)),
        road=TOWN,
        climate=AUTUMN,
        tags=("urban", "autumn"),
        horizon=238.0,
        people=(
            Person(_across(66, 3.0, 4.9, -8.4, 1.15), 1.80, warmth=0.75, reflectance=0.4),
            Person(_across(66.7, 3.3, 5.6, -8.3, 1.14), 1.68, warmth=0.8, reflectance=0.6),
            Person(_across(65.5, 3.9, 5.9, -8.6, 1.17), 1.73, warmth=0.6, reflectance=0.3),
            Person(_along(4.6, 58, -0.9), 1.85, warmth=0.7, reflectance=0.5),
            Person(_along(5.3, 58.6, -0.9), 1.64, warmth=0.7, reflectance=0.15),
            Person(_along(-5.4, 188, 0.3), 1.72, warmth=0.8),
        ),
        cars=(
            Car(-6.2, 30, heat=0.2, oncoming=True),
            Car(-6.2, 82, heat=0.8, oncoming=True),
            Car(2.85, 90, heat=0.1),
        ),
        things=(*town_things(3), Thing("sign", 3.5, 46, 2.5, 0.7, tempt=0.55)),
    )


def _rural_road() -> Recording:
    return Recording(
        name="rural_road",
        text="Country road, 20 m/s, lone walkers on the shoulder, one of them far off the road",
        context=1.0,
        speed=((0, 20), (15, 20)),
        road=COUNTRY,
        climate=WINTER,
        tags=("rural", "winter"),
        horizon=232.0,
        people=(
            Person(_along(2.6, 98, -1.2), 1.78, warmth=0.75, reflectance=0.4),
            Person(_along(7.6, 142, 0.3), 1.76, warmth=0.8, reflectance=0.38),
            Person(_along(-6.1, 188, 0.9), 1.72, warmth=0.75, reflectance=0.55, facing_deg=0),
            Person(_along(2.7, 250, -1.1), 1.80, warmth=0.7, reflectance=0.07),
            Person(_along(3.2, 386, -0.3), 1.76, warmth=0.8),
        ),
        things=(
            *country_things(4),
            Thing("sign", 3.4, 160, 2.4, 0.9, tempt=0.6),
            Thing("house", 24, 205, 6.5, 12, 14),
        ),
    )


def _rural_child() -> Recording:
    return Recording(
        name="rural_child",
        text="Country road, 14 m/s, a child with an adult and a child alone at the road",
        context=1.0,
        speed=((0, 14), (9, 14), (12, 9), (15, 9)),
        road=COUNTRY,
        climate=AUTUMN,
        tags=("rural", "autumn"),
        horizon=236.0,
        people=(
            Person(_along(2.7, 92, -0.9), 1.70, warmth=0.7, reflectance=0.5),
            Person(_along(3.3, 91.6, -0.9), 1.14, warmth=0.75, reflectance=0.5),
            Person(
                ((0, 4.2, 176), (9.5, 4.2, 176), (14, 1.6, 175), (30, -6, 174)),
                1.22,
                warmth=0.45,
                reflectance=0.3,
            ),
            Person(_along(-6.2, 262, 0.5), 1.60, warmth=0.8, facing_deg=0),
        ),
        things=(
            *country_things(5, 330),
            Thing("bush", 5.6, 170, 1.2, 1.4),
            Thing("house", -20, 120, 6.5, 12, 14),
            Thing("cabinet", 4.2, 120, 1.6, 1.0, 0.6, heat=0.9, tempt=0.7),
        ),
    )


def _rural_cyclist() -> Recording:
    return Recording(
        name="rural_cyclist",
        text="Country road, 13 m/s, a cyclist ahead (flagged ignore) and two walkers",
        context=1.0,
        speed=((0, 13), (9, 12), (15, 12)),
        road=COUNTRY,
        climate=WINTER,
        tags=("rural", "winter"),
        horizon=235.0,
        people=(
            Person(
                _along(1.1, 52, 5.6), 1.78, warmth=0.75, reflectance=0.5, facing_deg=0, cyclist=True
            ),
            Person(_along(-6.0, 96, -1.2), 1.74, warmth=0.75, reflectance=0.5),
            Person(_along(2.6, 150, -1.0), 1.80, warmth=0.3, reflectance=0.6),
            Person(_along(-6.4, 300, 0.8), 1.75, warmth=0.8, facing_deg=0),
        ),
        things=(*country_things(6, 330), Thing("sign", 3.3, 84, 2.3, 0.7, tempt=-0.7)),
    )


def _odd_pose() -> Recording:
    return Recording(
        name="odd_pose",
        text="Town, 6 m/s, two crouch, one bends over a boot, one squats down on the way",
        speed=((0, 6.5), (15, 6)),
        road=TOWN,
        climate=WINTER,
        tags=("urban", "winter"),
        horizon=237.0,
        people=(
            Person(
                _along(-4.5, 45.4, 0.0),
                1.76,
                warmth=0.4,
                reflectance=0.25,
                facing_deg=250,
                crouch=((0, 1), (15, 1)),
            ),
            Person(
                ((0, 3.1, 66.9), (15, 3.1, 67)),
                1.72,
                warmth=0.6,
                reflectance=0.45,
                facing_deg=20,
                bend=((0, 0.9), (6, 0.9), (6.8, 0.5), (7.5, 0.9), (15, 0.9)),
            ),
            Person(
                ((0, 4.8, 108), (10.7, 4.8, 97), (25, 4.8, 97)),
                1.74,
                warmth=0.55,
                reflectance=0.6,
                crouch=((0, 0), (10.9, 0), (11.4, 1), (15, 1)),
            ),
            Person(
                _along(5.6, 52, -0.1),
                1.68,
                warmth=0.12,
                reflectance=0.06,
                crouch=((0, 0.8), (15, 0.8)),
            ),
            Person(_across(198, 4, 4.6, -8, 1.1), 1.74, warmth=0.8),
        ),
        cars=(
            Car(-6.0, 46.5, heat=0.6, oncoming=True),
            Car(2.85, 70, heat=0.25),
            Car(-6.2, 84, heat=0.1, oncoming=True),
        ),
        things=town_things(7),
    )


def _summer_night() -> Recording:
    return Recording(
        name="summer_night",
        text="Town, 8 m/s, warm summer night: little contrast in the far infrared",
        speed=((0, 8), (15, 7.5)),
        road=TOWN,
        climate=SUMMER,
        tags=("urban", "summer"),
        horizon=236.0,
        people=(
            Person(_along(4.7, 50, -0.8), 1.70, warmth=0.75, reflectance=0.75),
            Person(_across(84, 5.6, -7.4, 4.5, 1.3), 1.78, warmth=0.8, reflectance=0.7),
            Person(_along(5.2, 112, -0.7), 1.66, warmth=0.85, reflectance=0.65),
            Person(_along(-8.2, 72, 0.4), 1.80, warmth=0.7, reflectance=0.8, facing_deg=0),
        ),
        cars=(
            Car(2.85, 66, heat=0.9),
            Car(-6.2, 40, heat=0.3, oncoming=True),
            Car(-6.2, 104, heat=0.7, oncoming=True),
        ),
        things=(*town_things(8), Thing("sign", 3.6, 96, 2.6, 0.6)),
    )


def _oncoming_glare() -> Recording:
    return Recording(
        name="oncoming_glare",
        text="Village road, 10 m/s slowing to 4, two oncoming cars dazzle the near-infrared camera",
        context=0.5,
        speed=((0, 10), (7, 10), (9.5, 4), (15, 4)),
        road=Road(left=-5.2, right=1.75, pavement=2.0),
        climate=AUTUMN,
        tags=("village", "autumn"),
        horizon=233.0,
        people=(
            Person(_along(-6.2, 78, -0.8), 1.76, warmth=0.75, reflectance=0.5),
            Person(_along(2.9, 86, 0.2), 1.70, warmth=0.7, reflectance=0.5, facing_deg=0),
            Person(_along(-6.8, 122.7, 0.5), 1.72, warmth=0.8, reflectance=0.9),
            Person(_along(3.0, 152, -1.3), 1.68, warmth=0.7, reflectance=0.45),
        ),
        cars=(
            Car(-3.4, 138, speed=-11, oncoming=True, heat=0.9, lights=True),
            Car(-3.4, 258, speed=-11, oncoming=True, heat=0.9, lights=True),
        ),
        things=(
            *town_things(9, 300, left=-14, right=11),
            Thing("sign", 4.2, 118, 2.4, 0.7, tempt=0.4),
        ),
    )


def _winter_frost() -> Recording:
    return Recording(
        name="winter_frost",
        text="Town in hard frost, 8 m/s, thick cold coats: only faces and hands are warm",
        speed=((0, 8), (15, 8)),
        road=TOWN,
        climate=FROST,
        tags=("urban", "winter"),
        horizon=235.0,
        people=(
            Person(_along(4.7, 56, -0.9), 1.78, warmth=0.10, reflectance=0.55),
            Person(_across(98, 6.2, 4.6, -7.5, 1.3), 1.70, warmth=0.15, reflectance=0.5),
            Person(_along(5.0, 104, 0.6), 1.64, warmth=0.08, reflectance=0.10, facing_deg=0),
            Person(_along(-8.0, 74, 0.2), 1.82, warmth=0.6, reflectance=0.2),
            Person(_along(-2.0, 214, 0.4), 1.75, warmth=0.6, facing_deg=0),
        ),
        cars=(
            Car(2.85, 30, heat=0.0),
            Car(-6.2, 58, heat=0.95, oncoming=True, tempt=0.5),
            Car(-6.2, 88, heat=0.0, oncoming=True, height_m=1.9, length_m=5.0),
        ),
        things=(*town_things(10), Thing("sign", 3.6, 72, 2.6, 0.6, tempt=-0.7)),
    )
