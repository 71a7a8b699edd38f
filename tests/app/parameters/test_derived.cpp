// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "app/parameters/derived.hpp"

namespace flotilla::app {
namespace {

constexpr std::uint32_t kSeed = 71;

/// A boat of any size between a 0.3 kg model and one of a ton, with a measured lag.
Parameters any_boat(std::mt19937& random) {
  const auto draw = [&](double least, double most) {
    const double share = std::uniform_real_distribution<>(0, 1)(random);
    return static_cast<float>(least * std::pow(most / least, share));
  };
  Parameters p;
  p.VES_M11 = draw(0.3, 1000);
  p.VES_M22 = draw(1.2, 2.5) * p.VES_M11;
  p.BOAT_LEN = std::cbrt(p.VES_M11) * draw(0.4, 0.8);
  p.VES_M33 = p.VES_M11 * p.BOAT_LEN * p.BOAT_LEN * draw(0.08, 0.3);
  p.THR_LAG = draw(0.01, 0.4);
  p.VES_D11 = p.VES_M11 * draw(0.05, 3);
  p.VES_D33 = std::max(p.VES_M33 * draw(0.05, 3), 0.001F);
  p.THR_FWD_MAX = p.THR_REV_MAX = 2 * p.VES_M11;
  p.THR_ARM = 0.2F * p.BOAT_LEN;
  return p;
}

/// Damping of m ν̇ = X − d ν, τ Ẋ = −k ν − X: half the sum of its poles over the root of their
/// product.
double damping(double m, double d, double k, double tau) {
  return (1 / tau + d / m) / (2 * std::sqrt((d + k) / (m * tau)));
}

TEST_CASE("the paper's vessel gets the paper's gains, to the last bit, and so the law's defaults") {
  const Parameters p = derived({});
  CHECK(p.LAW_KDU == 10);
  CHECK(p.LAW_KDR == 10);
  CHECK(p.LAW_OBS_BW == 2);
  CHECK(p.LAW_CUR_BW == 0.1F);
  CHECK(p.LAW_XT_DIST == 1);
  CHECK(p.LAW_R_MAX == 0.8F);
  CHECK_FALSE(gain_fault({}));
}

TEST_CASE("a gain set by an operator is used, even 0, and changes no other") {
  for (const float value : {0.0F, 0.07F, 0.7F}) {
    for (float Parameters::* gain :
         {&Parameters::LAW_KDU, &Parameters::LAW_KDR, &Parameters::LAW_OBS_BW,
          &Parameters::LAW_CUR_BW, &Parameters::LAW_XT_DIST, &Parameters::LAW_R_MAX}) {
      Parameters p, expected = derived({});
      p.*gain = expected.*gain = value;
      const Parameters found = derived(p);
      for (const ParameterInfo& info : kParameterList) {
        CHECK_MESSAGE(found.*info.member == expected.*info.member, info.name);
      }
    }
  }
}

TEST_CASE("derived gains give a damped loop and are valid, on any boat") {
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const Parameters given = any_boat(random), p = derived(given);
    for (const ParameterInfo& info : kParameterList) CHECK(is_valid(info, p.*info.member));
    CHECK(damping(p.VES_M11, p.VES_D11, p.LAW_KDU, p.THR_LAG + 0.018) > 0.9);
    CHECK(damping(p.VES_M33, p.VES_D33, p.LAW_KDR, p.THR_LAG + 0.018) > 0.6);
    const auto found = gain_fault(given);
    CHECK_MESSAGE(!found, given.THR_LAG, " s: ", found ? found->gain : "");
  }
}

TEST_CASE("units do not matter: a boat of twice the mass, inertia and drag gets twice the gains") {
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int i = 0; i < 200; ++i) {
    Parameters p = any_boat(random);
    const Parameters one = derived(p);
    for (float Parameters::* scaled :
         {&Parameters::VES_M11, &Parameters::VES_D11, &Parameters::VES_M33, &Parameters::VES_D33}) {
      p.*scaled *= 2;
    }
    const Parameters two = derived(p);
    // 10,000 is the greatest that either parameter may be.
    CHECK(two.LAW_KDU == doctest::Approx(std::min(2 * one.LAW_KDU, 1e4F)).epsilon(0.01));
    CHECK(two.LAW_KDR == doctest::Approx(std::min(2 * one.LAW_KDR, 1e4F)).epsilon(0.01));
    CHECK(two.LAW_OBS_BW == one.LAW_OBS_BW);
  }
}

TEST_CASE("a heavy boat with unknown thrust lag gets slower loops than one without lag") {
  Parameters p;
  p.VES_M11 = 80;
  p.VES_M33 = 40;
  const Parameters unknown = derived(p);
  p.THR_LAG = 0;
  const Parameters none = derived(p);
  CHECK(unknown.LAW_KDU < none.LAW_KDU / 4);
  CHECK(unknown.LAW_KDR < none.LAW_KDR / 4);
}

TEST_CASE("each kind of gain conflict is reported with its time constants") {
  Parameters p;  // an Otter
  p.VES_M11 = 85.28F;
  p.VES_M33 = 41.45F;
  p.VES_D11 = 50.1F;
  p.VES_D33 = 62;
  p.THR_LAG = 0.1F;
  REQUIRE_FALSE(gain_fault(p));
  const Parameters fits = p;
  p.LAW_OBS_BW = 5;
  REQUIRE_FALSE(gain_fault(p));
  p.THR_LAG = 0.3F;
  auto found = gain_fault(p);
  REQUIRE(found);
  CHECK(found->gain == "LAW_OBS_BW");
  CHECK(found->time_s == 0.2F);
  CHECK(found->other == "THR_LAG");
  CHECK(found->allowed_s == doctest::Approx(0.318));
  CHECK(found->more);
  p = fits;
  p.LAW_KDR = 1200;
  found = gain_fault(p);
  REQUIRE(found);
  CHECK(found->gain == "LAW_KDR");
  CHECK(found->other == "THR_LAG");
  CHECK(found->time_s == doctest::Approx(41.45 / 1262));
  CHECK(damping(41.45, 62, 41.45 / found->allowed_s - 62, 0.118) == doctest::Approx(0.5));
  CHECK(found->more);
  p.THR_LAG = -1;  // lag unknown, and so is its limit on the gains
  CHECK_FALSE(gain_fault(p));
  p = fits;
  p.VES_D33 = 5;
  p.LAW_KDR = 10;
  found = gain_fault(p);
  REQUIRE(found);
  CHECK(found->gain == "LAW_KDR");
  CHECK(found->other == "LAW_KPSI");
  CHECK(found->time_s == doctest::Approx(41.45 / 15));
  CHECK(found->allowed_s == 2);
  CHECK_FALSE(found->more);
}

TEST_CASE("a long boat looks as far ahead as its lateral loop needs, a short one less") {
  Parameters p;
  p.BOAT_LEN = 0.65F;
  CHECK(derived(p).LAW_XT_DIST == doctest::Approx(0.5));
  p.BOAT_LEN = 4.9F;
  CHECK(derived(p).LAW_XT_DIST == 1);  // propellers without lag: no longer than the paper's
  p.THR_LAG = 0.5F;
  const double yaw_s = 1.81 * 0.518;
  CHECK(derived(p).LAW_XT_DIST == doctest::Approx(2 * 1.5 * yaw_s).epsilon(1e-3));
  p.LAW_U_MAX = 0;  // no limit: 1.5 m/s
  CHECK(derived(p).LAW_XT_DIST == doctest::Approx(2 * 1.5 * yaw_s).epsilon(1e-3));
  p.LAW_U_MAX = 5;
  CHECK(derived(p).LAW_XT_DIST == doctest::Approx(4.9 / 1.3));
}

TEST_CASE(
    "a boat with yaw drag that grows with speed, or a weak propeller, gets a lower LAW_R_MAX") {
  Parameters p;
  p.BOAT_LEN = 1.2F;
  p.VES_D33U = 33.5F;
  p.THR_ARM = 0.295F;
  p.THR_FWD_MAX = 40.6F;
  p.THR_REV_MAX = 22.6F;
  const float rate = derived(p).LAW_R_MAX;
  CHECK(rate == doctest::Approx(0.6 * 0.295 * 63.2 / (0.864 + 33.5 * 0.75)));
  p.THR_BALANCE = -0.2F;
  CHECK(derived(p).LAW_R_MAX == doctest::Approx(0.8 * rate));
  p.LAW_U_MAX = 0.5F;
  CHECK(derived(p).LAW_R_MAX > rate);
}

}  // namespace
}  // namespace flotilla::app
