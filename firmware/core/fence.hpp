// SPDX-License-Identifier: MIT
// How far a place, or a straight leg, is from the nearest boundary of a fence.
//
//   circle   d(p) = R − |p − m|                          d(leg) = R − max(|a − m|, |b − m|)
//   polygon  d(p) = ±min over the edges of |p − edge|    + inside: an odd number of edges crosses
//                                                        the line from p to the south
//   c(p) = d(p) to stay inside, −d(p) to stay outside
//   c(leg) = min(c(a), c(b), min over the corners of |corner − leg|), 0 where an edge crosses it
//   |p − edge| : |ê × (p − a)| where 0 < ê · (p − a) < L, else the distance from the nearer end
//
//  symbol  meaning                                            frame        unit   tested range
//  c       clearance: positive where permitted                             m
//  p       place                                              north, east  m      ±4000
//  a, b    ends of the leg                                    north, east  m      ±4000
//  m, R    centre and radius of a circle                      north, east  m      ±2000, 1 … 2000
//  ê, L    direction and length of an edge
//
// The clearance of several zones is the least of theirs. It changes by no more than the way between
// two places, so a boat well inside need not compute it again at once.
//
// Not in paper.
//
// Q16.16: tested within ±8000 (differences of places, m)
#pragma once

#include <cstddef>
#include <span>

#include "core/scalar/scalar.hpp"
#include "core/types.hpp"

namespace flotilla::core {

/// An area to stay inside, or outside.
template <class S>
struct Zone {
  std::span<const Vec2<S>> corners{};  ///< in order round a polygon; a circle's centre alone
  S radius{};                          ///< of a circle
  bool keeps_in = true;
};

/// From p to the straight line from a to b.
template <class S>
S distance_to(const Vec2<S>& p, const Vec2<S>& a, const Vec2<S>& b) {
  const Vec2<S> edge{b.x - a.x, b.y - a.y}, way{p.x - a.x, p.y - a.y};
  const S L = hypot(edge.x, edge.y);
  if (!(S(0) < L)) return hypot(way.x, way.y);
  const Vec2<S> e{edge.x / L, edge.y / L};
  const S along = sum_of_products(e.x, way.x, e.y, way.y);
  if (along <= S(0)) return hypot(way.x, way.y);
  if (L <= along) return hypot(p.x - b.x, p.y - b.y);
  return abs(difference_of_products(e.x, way.y, e.y, way.x));
}

/// Whether the lines from a to b and from c to d cross; either result if they only touch.
template <class S>
bool crosses(const Vec2<S>& a, const Vec2<S>& b, const Vec2<S>& c, const Vec2<S>& d) {
  const Vec2<S> leg{b.x - a.x, b.y - a.y};
  const S L = hypot(leg.x, leg.y);
  if (!(S(0) < L)) return false;
  const Vec2<S> e{leg.x / L, leg.y / L}, to_c{c.x - a.x, c.y - a.y}, to_d{d.x - a.x, d.y - a.y};
  const S c_across = difference_of_products(e.x, to_c.y, e.y, to_c.x);
  const S d_across = difference_of_products(e.x, to_d.y, e.y, to_d.x);
  if ((c_across < S(0)) == (d_across < S(0))) return false;
  const S c_along = sum_of_products(e.x, to_c.x, e.y, to_c.y);
  const S d_along = sum_of_products(e.x, to_d.x, e.y, to_d.y);
  const S at = c_along + scaled(d_along - c_along, c_across, c_across - d_across);
  return S(0) <= at && at <= L;
}

/// Between the lines from a to b and from c to d; 0 if they cross.
template <class S>
S distance_between(const Vec2<S>& a, const Vec2<S>& b, const Vec2<S>& c, const Vec2<S>& d) {
  if (crosses(a, b, c, d)) return S(0);
  return min(min(distance_to(a, c, d), distance_to(b, c, d)),
             min(distance_to(c, a, b), distance_to(d, a, b)));
}

/// c(p); the zone has at least one corner.
template <class S>
S clearance(const Zone<S>& zone, const Vec2<S>& p) {
  const auto& corners = zone.corners;
  if (corners.size() < 3) {
    const S inside = zone.radius - hypot(p.x - corners[0].x, p.y - corners[0].y);
    return zone.keeps_in ? inside : -inside;
  }
  bool within = false;
  S nearest = distance_to(p, corners.back(), corners[0]);
  for (std::size_t i = 0, before = corners.size() - 1; i < corners.size(); before = i++) {
    const Vec2<S>&a = corners[before], &b = corners[i];
    nearest = min(nearest, distance_to(p, a, b));
    if ((p.y < a.y) == (p.y < b.y)) continue;
    if (a.x + scaled(b.x - a.x, p.y - a.y, b.y - a.y) < p.x) within = !within;
  }
  return within == zone.keeps_in ? nearest : -nearest;
}

/// c(leg) of the leg from a to b.
template <class S>
S clearance(const Zone<S>& zone, const Vec2<S>& a, const Vec2<S>& b) {
  const auto& corners = zone.corners;
  if (corners.size() < 3 && !zone.keeps_in) return distance_to(corners[0], a, b) - zone.radius;
  S least = min(clearance(zone, a), clearance(zone, b));
  if (corners.size() < 3) return least;
  for (std::size_t i = 0, before = corners.size() - 1; i < corners.size(); before = i++) {
    if (!(S(0) < least)) return least;
    if (crosses(a, b, corners[before], corners[i])) return S(0);
    least = min(least, distance_to(corners[i], a, b));
  }
  return least;
}

}  // namespace flotilla::core
