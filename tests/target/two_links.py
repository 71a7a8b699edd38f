# SPDX-License-Identifier: MIT
"""A boat that hears others on several links."""

from tests.target.sea import Sea, Tick
from tests.target.stations import GCS, GCS_COMPONENT, Station, heartbeat

OTHER = Station(7, 1)  # a boat beyond another link
TO_OTHER = (7, 1)


def sent(tick: Tick, link: int) -> bytes:
    return b"".join(data for at, data in tick.mavlink if at == link)


def known(links: int, where: dict[int, list[Station]]) -> Sea:
    """A boat that has heard each station's HEARTBEAT on its link, and forwarded it."""
    sea = Sea(links=links)
    sea.run(0.5)
    for link, stations in where.items():
        for station in stations:
            sea.say(heartbeat(), sender=station, link=link)
    sea.run(0.35)
    sea.ticks.clear()
    return sea


def two_links() -> Sea:
    return known(2, {0: [Station(GCS, GCS_COMPONENT)], 1: [OTHER]})
