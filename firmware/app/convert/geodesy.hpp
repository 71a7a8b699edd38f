// SPDX-License-Identifier: MIT
// Points at sea level on the WGS 84 ellipsoid, and the planes that touch it at local origins.
//
//   P(φ, λ) = w⁻¹ [a cos φ cos λ   a cos φ sin λ   a (1 − e²) sin φ]ᵀ      w² = 1 − e² sin² φ
//   local (north, east) of P: its components along the plane's axes     tan φ = Z / ((1 − e²) √(X² + Y²))
//
// A local position stands for the point of the sea straight below it in its plane (10 km out the
// plane is 8 m above the sea), so both conversions are exact inverses. On a lake at height h a
// metre corresponds to R/(R + h) metres at sea level. The earth's mean radius R is precise enough:
// 0.3 mm in 2 km at 500 m.
#pragma once

#include <cstdint>

namespace flotilla::app::geodesy {

/// Earth-centred, earth-fixed, m.
struct Vec3 {
  double x, y, z;
};

struct NorthEast {
  double north_m, east_m;
};

struct NorthEastDown {
  double north_m, east_m, down_m;
};

/// The plane tangent to the ellipsoid at a point, with axes north and east there.
class Plane {
 public:
  /// height_m: of the water there.
  Plane(std::int32_t latitude_degE7, std::int32_t longitude_degE7, double height_m = 0);

  const Vec3& origin() const { return origin_; }

  /// A point at sea level, relative to the plane's origin.
  NorthEastDown local_of(const Vec3& point) const;

  /// The sea-level point below.
  Vec3 sea_level(const NorthEast& local) const;

  /// Clockwise angle from this plane's north to the other's, rad: about −Δλ sin φ, a quarter of a
  /// milliradian at 49° for origins 1.4 km apart.
  double turn_of(const Plane& other) const;

 private:
  Vec3 origin_, north_, east_, down_;
  double scale_;  // length at sea level of a metre at this height
};

/// Latitude and longitude of a point at sea level, rounded to degE7.
struct Degrees {
  std::int32_t latitude, longitude;
};
Degrees degrees_of(const Vec3& point);

double distance_m(const Vec3& a, const Vec3& b);

}  // namespace flotilla::app::geodesy
