// SPDX-License-Identifier: MIT
#include "app/convert/geodesy.hpp"

#include "app/convert/portable.hpp"

namespace flotilla::app::geodesy {
namespace {

constexpr double kA_m = 6378137.0;
constexpr double kFlattening = 1 / 298.257223563;
constexpr double kE2 = kFlattening * (2 - kFlattening);
constexpr double kB_m = kA_m * (1 - kFlattening);
constexpr double kMeanRadius_m = 6371008.8;
constexpr double kRadPerDegE7 = portable::kPi / 180e7;

double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec3 minus(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

/// Scales the ellipsoid to the unit sphere.
Vec3 scaled(const Vec3& v) { return {v.x / kA_m, v.y / kA_m, v.z / kB_m}; }

std::int32_t degE7_of(double rad) {
  return static_cast<std::int32_t>(portable::nearest(rad / kRadPerDegE7));
}

}  // namespace

Plane::Plane(std::int32_t latitude_degE7, std::int32_t longitude_degE7, double height_m)
    : scale_(kMeanRadius_m / (kMeanRadius_m + height_m)) {
  const auto [sp, cp] = portable::sin_cos(latitude_degE7 * kRadPerDegE7);
  const auto [sl, cl] = portable::sin_cos(longitude_degE7 * kRadPerDegE7);
  const double n_m = kA_m / portable::root(1 - kE2 * sp * sp);
  origin_ = {n_m * cp * cl, n_m * cp * sl, n_m * (1 - kE2) * sp};
  north_ = {-sp * cl, -sp * sl, cp};
  east_ = {-sl, cl, 0};
  down_ = {-cp * cl, -cp * sl, -sp};
}

NorthEastDown Plane::local_of(const Vec3& point) const {
  const Vec3 from_origin = minus(point, origin_);
  return {dot(from_origin, north_) / scale_, dot(from_origin, east_) / scale_,
          dot(from_origin, down_)};
}

Vec3 Plane::sea_level(const NorthEast& local) const {
  const double n = local.north_m * scale_, e = local.east_m * scale_;
  const Vec3 above{origin_.x + n * north_.x + e * east_.x, origin_.y + n * north_.y + e * east_.y,
                   origin_.z + n * north_.z + e * east_.z};
  // |scaled(above + t down)| = 1; takes the nearer of the two solutions.
  const Vec3 p = scaled(above), d = scaled(down_);
  const double b = -dot(p, d), c = dot(p, p) - 1;
  const double t = c / (b + portable::root(b * b - dot(d, d) * c));
  return {above.x + t * down_.x, above.y + t * down_.y, above.z + t * down_.z};
}

double Plane::turn_of(const Plane& other) const {
  return portable::atan2(dot(other.north_, east_), dot(other.north_, north_));
}

Degrees degrees_of(const Vec3& p) {
  const double phi = portable::atan2(p.z, (1 - kE2) * portable::hypot(p.x, p.y));
  return {degE7_of(phi), degE7_of(portable::atan2(p.y, p.x))};
}

double distance_m(const Vec3& a, const Vec3& b) {
  const Vec3 d = minus(a, b);
  return portable::root(dot(d, d));
}

}  // namespace flotilla::app::geodesy
