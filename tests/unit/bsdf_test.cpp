// SPDX-License-Identifier: Apache-2.0
// The laws of scattering: energy, densities, reciprocity, Fresnel and Snell.
#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "raytracer/bsdf.hpp"

namespace triad::raytracer {
namespace {

constexpr double kPiD = std::numbers::pi;
constexpr LobeMask kAll{};

Float3 direction(double cosine, double angle) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {static_cast<float>(sine * std::cos(angle)), static_cast<float>(sine * std::sin(angle)),
          static_cast<float>(cosine)};
}

SurfaceMaterial material(Float3 base, float metallic, float roughness, float ior, float transmission = 0) {
  return {base, metallic, roughness, transmission, ior};
}

std::vector<SurfaceMaterial> blurred() {
  const Float3 orange{.9f, .6f, .2f};
  return {material(orange, 0, 1, 1),      material(orange, 1, .3f, 1.5f),   material(orange, 1, 1, 1.5f),
          material(orange, 0, .2f, 1.5f), material(orange, .5f, .5f, 1.5f), material({1, 1, 1}, 0, .6f, 1.33f),
          material(orange, 0, .4f, 0)};
}

Bsdf<> bsdf_of(const SurfaceMaterial& m, Float3 to, bool outside = true) { return {m, to, outside, kAll, true}; }

// The integral over the hemisphere of what `f` makes of a direction, midpoint rule in z and angle.
template <class F>
double integrate(F f, double z0 = 0, double z1 = 1, double a0 = 0, double a1 = 2 * kPiD, int steps = 500) {
  double sum = 0;
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j)
      sum += f(direction(z0 + (z1 - z0) * (i + .5) / steps, a0 + (a1 - a0) * (j + .5) / steps));
  return sum * (z1 - z0) * (a1 - a0) / steps / steps;
}

TEST(Bsdf, LambertReflectsItsAlbedo) {
  const Bsdf<> bsdf = bsdf_of(material({.8f, .5f, .1f}, 0, 1, 1), direction(.4, 1));
  EXPECT_NEAR(integrate([&](Float3 from) { return static_cast<double>(bsdf.eval(from).value().x); }), .8, 1e-5);
  EXPECT_NEAR(integrate([&](Float3 from) { return static_cast<double>(bsdf.eval(from).pdf()); }), 1, 1e-5);
  for (int i = 0; i < 100; ++i) {
    const BsdfSample sample = bsdf.sample(.5f, static_cast<float>(i) / 100, .3f);
    EXPECT_NEAR(sample.weight.x, .8, 1e-5);
    EXPECT_EQ(sample.lobe, Lobe::kDiffuse);
  }
}

// Samples over 8 x 8 cells of the hemisphere (and below it) against the integral of the density over each cell.
TEST(Bsdf, SamplesFollowTheirDensity) {
  constexpr int kCells = 8, kSide = 256, kSamples = kSide * kSide * 4;
  for (const SurfaceMaterial& m : blurred()) {
    for (const double cosine : {.2, .9}) {
      const Bsdf<> bsdf = bsdf_of(m, direction(cosine, .5));
      std::vector<double> counts(kCells * kCells + 1), expected(kCells * kCells + 1);
      uint64_t state = 1;
      const auto uniform = [&] {
        state = state * 6364136223846793005u + 1442695040888963407u;
        return static_cast<float>(state >> 40) * 0x1p-24f;
      };
      for (int i = 0; i < kSamples; ++i) {
        const float choose = uniform(), u = uniform(), v = uniform();
        const BsdfSample sample = bsdf.sample(choose, u, v);
        if (sample.lobe == Lobe::kNone) {
          ++counts.back();
          continue;
        }
        ASSERT_NEAR(sample.pdf / bsdf.eval(sample.from).pdf(), 1, 1e-5);
        const double angle = std::atan2(sample.from.y, sample.from.x) / (2 * kPiD);
        const int row = std::min(kCells - 1, static_cast<int>(sample.from.z * kCells));
        const int column = std::min(kCells - 1, static_cast<int>((angle - std::floor(angle)) * kCells));
        ++counts[row * kCells + column];
      }
      double inside = 0, chi2 = 0;
      int freedom = -1;
      for (int cell = 0; cell < kCells * kCells; ++cell) {
        const double z = cell / kCells, a = cell % kCells;
        expected[cell] =
            kSamples * integrate([&](Float3 from) { return static_cast<double>(bsdf.eval(from).pdf()); }, z / kCells,
                                 (z + 1) / kCells, 2 * kPiD * a / kCells, 2 * kPiD * (a + 1) / kCells, 100);
        inside += expected[cell];
      }
      EXPECT_LE(inside, kSamples * (1 + 2e-3));
      expected.back() = std::max(0., kSamples - inside);
      for (size_t i = 0; i < expected.size(); ++i) {
        if (expected[i] < 10) continue;
        ++freedom;
        chi2 += (counts[i] - expected[i]) * (counts[i] - expected[i]) / expected[i];
      }
      // Wilson and Hilferty's approximation: 4.5 standard deviations.
      const double k = freedom, z = (std::cbrt(chi2 / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
      EXPECT_LT(z, 4.5) << m.metallic << " " << m.roughness << " " << m.ior << " at " << cosine;
    }
  }
}

TEST(Bsdf, IsReciprocal) {
  for (const SurfaceMaterial& m : blurred())
    for (const double a : {.05, .3, .8, 1.})
      for (const double b : {.1, .5, .95}) {
        const Float3 to = direction(a, .3), from = direction(b, 2.2);
        const Float3 there = bsdf_of(m, to).eval(from).value() / from.z;
        const Float3 back = bsdf_of(m, from).eval(to).value() / to.z;
        EXPECT_NEAR(there.x / back.x, 1, 2e-4);
        EXPECT_NEAR(there.z / back.z, 1, 2e-4);
      }
}

TEST(Bsdf, NeverCreatesEnergy) {
  for (const float roughness : {0.f, .02f, .1f, .5f, 1.f})
    for (const float metallic : {0.f, .5f, 1.f})
      for (const float ior : {0.f, 1.f, 1.5f})
        for (const float transmission : {0.f, .5f, 1.f})
          for (const double cosine : {1e-3, .1, .5, 1.}) {
            const Bsdf<> bsdf =
                bsdf_of(material({1, 1, 1}, metallic, roughness, ior, transmission), direction(cosine, 0));
            double sum = 0;
            constexpr int kSteps = 16, kChoices = 256;
            for (int i = 0; i < kSteps; ++i)
              for (int j = 0; j < kSteps; ++j)
                for (int k = 0; k < kChoices; ++k) {
                  const auto at = [](int n, int of) {
                    return (static_cast<float>(n) + .5f) / static_cast<float>(of);
                  };
                  const BsdfSample sample = bsdf.sample(at(k, kChoices), at(i, kSteps), at(j, kSteps));
                  if (sample.lobe == Lobe::kNone) continue;
                  ASSERT_TRUE(is_finite(sample.weight));
                  // Radiance inside of glass is denser by ior^2; energy is not.
                  sum += static_cast<double>(sample.weight.x * (sample.from.z < 0 ? bsdf.squeeze() : 1));
                }
            // Beyond 1: the error of a midpoint rule with this many points.
            EXPECT_LE(sum / (kSteps * kSteps * kChoices), 1 + .005)
                << roughness << " " << metallic << " " << ior << " " << transmission << " " << cosine;
          }
}

TEST(Fresnel, ClosedForms) {
  for (const double n : {1.1, 1.5, 2.4}) {
    const float eta = static_cast<float>(n);
    float cos_t = 0;
    const double normal = (n - 1) / (n + 1);
    EXPECT_NEAR(fresnel_dielectric(1, eta, cos_t), normal * normal, 1e-6);
    EXPECT_NEAR(cos_t, 1, 1e-6);
    EXPECT_NEAR(fresnel_dielectric(0, eta, cos_t), 1, 1e-6);
    // At Brewster's angle, tan = n, one polarisation does not reflect at all, the other by (n^2 - 1) / (n^2 + 1).
    const double other = (n * n - 1) / (n * n + 1);
    EXPECT_NEAR(fresnel_dielectric(static_cast<float>(1 / std::sqrt(1 + n * n)), eta, cos_t), other * other / 2,
                1e-6);
    // The same from inside at the refracted angle; total past the critical one.
    for (const double c : {.3, .7, .95}) {
      const float out = fresnel_dielectric(static_cast<float>(c), eta, cos_t);
      const float inside_cos = cos_t;
      EXPECT_NEAR(inside_cos, std::sqrt(1 - (1 - c * c) / n / n), 1e-6);
      EXPECT_NEAR(fresnel_dielectric(inside_cos, 1 / eta, cos_t), out, 1e-5);
      EXPECT_NEAR(cos_t, c, 1e-5);
    }
    const double critical = std::sqrt(1 - 1 / n / n);
    EXPECT_EQ(fresnel_dielectric(static_cast<float>(critical * .99), 1 / eta, cos_t), 1);
    EXPECT_LT(fresnel_dielectric(static_cast<float>(critical + .01), 1 / eta, cos_t), 1);
  }
}

TEST(Glass, RefractsBySnellsLaw) {
  for (const float ior : {1.33f, 1.5f, 2.4f})
    for (const bool outside : {true, false})
      for (const double cosine : {.8, .9, .99}) {
        const Bsdf<> bsdf = bsdf_of(material({1, 1, 1}, 0, 0, ior, 1), direction(cosine, 1), outside);
        const BsdfSample sample = bsdf.sample(0x1.fffffep-1f, .5f, .5f);
        const double eta = outside ? ior : 1 / static_cast<double>(ior), sine = std::sqrt(1 - cosine * cosine);
        ASSERT_EQ(sample.lobe, Lobe::kRefraction);
        if (sine / eta > 1) {
          EXPECT_GT(sample.from.z, 0);  // total reflection
          EXPECT_NEAR(sample.weight.x, 1, 1e-6);
          continue;
        }
        EXPECT_LT(sample.from.z, 0);
        EXPECT_NEAR(length(sample.from), 1, 1e-5);
        EXPECT_NEAR(std::hypot(sample.from.x, sample.from.y), sine / eta, 1e-5);
        EXPECT_NEAR(sample.weight.x * eta * eta, 1, 1e-4);
        EXPECT_EQ(sample.pdf, 0);
      }
}

TEST(Glass, OfNearlyNoIndexLetsAllThrough) {
  for (const float ior : {1.f, 1 + 1e-6f, 1 - 1e-6f})
    for (const double cosine : {.05, .5, 1.}) {
      const Float3 to = direction(cosine, 1);
      const BsdfSample sample = bsdf_of(material({1, 1, 1}, 0, 0, ior, 1), to).sample(.5f, .5f, .5f);
      EXPECT_NEAR(sample.weight.x, 1, 1e-4);
      EXPECT_NEAR(sample.from.x, -to.x, 1e-4);
      EXPECT_NEAR(sample.from.z, -to.z, 1e-4);
    }
}

TEST(Metal, OfNoRoughnessIsAMirror) {
  for (const float roughness : {0.f, 1e-6f}) {
    const Float3 to = direction(.3, 1);
    const Bsdf<> bsdf = bsdf_of(material({.9f, .6f, .2f}, 1, roughness, 1.5f), to);
    const BsdfSample sample = bsdf.sample(.5f, .2f, .7f);
    EXPECT_EQ(sample.lobe, Lobe::kMirror);
    EXPECT_EQ(sample.from, (Float3{-to.x, -to.y, to.z}));
    EXPECT_NEAR(sample.weight.y, .6 + .4 * std::pow(.7, 5), 1e-5);  // Schlick's Fresnel, as glTF asks
    EXPECT_FALSE(bsdf.blurs());
    EXPECT_EQ(bsdf.eval({-to.x, -to.y, to.z}).value(), Float3{});
  }
}

TEST(Coat, HidesExactlyAsMuchOfItsBaseAsItReflects) {
  for (const float roughness : {.02f, .1f, .35f, .7f, 1.f})
    for (const double cosine : {.06, .3, .7, 1.}) {
      const Bsdf<> bsdf = bsdf_of(material({1, 1, 1}, 0, roughness, 1.5f), direction(cosine, 0));
      const double matt = integrate([&](Float3 from) { return static_cast<double>(bsdf.eval(from).diffuse.x); });
      const CoatAlbedo coat = coat_albedo(static_cast<float>(cosine), roughness);
      EXPECT_NEAR(matt + static_cast<double>(.04f * coat.at_normal + coat.at_grazing), 1, 1e-4);
    }
}

}  // namespace
}  // namespace triad::raytracer
