// SPDX-License-Identifier: Apache-2.0
// How surfaces scatter light. All directions are unit vectors in a frame whose z axis is the shading normal, and
// both point away from the surface: `to` where the light goes (towards the camera), `from` where it comes from.
//
// The opaque part of glTF's metallic-roughness model (glTF 2.0, appendix B) is one GGX lobe, whose Fresnel factor
// mixes metal and coat, over a matt base. Where the appendix joins the two so that energy appears at grazing
// angles, the base is scaled here by (1 - E(to)) (1 - E(from)) / (1 - mean E), E being the coat's directional
// albedo (Kelemen and Szirmay-Kalos, Eurographics 2001 short papers, equation 4): reciprocal, and a white base under
// any coat reflects exactly as much as it receives. An ior of 1 leaves a perfectly matt base alone.
#pragma once

#include <cmath>

#include "material.hpp"
#include "vec.hpp"

namespace triad::raytracer {

// Reflectance of a smooth boundary, unpolarised (Born and Wolf, Principles of Optics, 1.5.2); cos_i in [0, 1];
// eta: index of the far side over that of the near side. 1 where reflection is total. Writes the cosine of the
// refracted ray with its own normal, 0 if there is none.
float fresnel_dielectric(float cos_i, float eta, float& cos_t);

// The refracted direction by Snell's law, on the other side of the surface from `to`.
inline Float3 refract(Float3 to, float eta, float cos_t) {
  return {-to.x / eta, -to.y / eta, to.z > 0 ? -cos_t : cos_t};
}

// Schlick's weight (1 - cos)^5 of the grazing reflectance.
inline float schlick_weight(float cosine) {
  const float c = std::clamp(1 - cosine, 0.f, 1.f);
  return c * c * c * c * c;
}

// A GGX (Trowbridge-Reitz) lobe of one width, alpha = roughness^2 in (0, 1], isotropic. Heitz, Understanding the
// Masking-Shadowing Function, JCGT 3(2), 2014 (height-correlated Smith); Sampling the GGX Distribution of Visible
// Normals, JCGT 7(4), 2018.
struct Ggx {
  float alpha;

  // Density of microfacet normals; written so that nothing cancels where the lobe is narrow.
  float density(Float3 half) const {
    const float across = (half.x * half.x + half.y * half.y) / (alpha * alpha), along = half.z * half.z;
    return 1 / (kPi * alpha * alpha * (across + along) * (across + along));
  }
  // Smith's auxiliary function.
  float lambda(Float3 direction) const {
    const float c2 = direction.z * direction.z;
    const float t2 = (direction.x * direction.x + direction.y * direction.y) / c2;
    return (std::sqrt(1 + alpha * alpha * t2) - 1) / 2;
  }
  float masking(Float3 direction) const { return 1 / (1 + lambda(direction)); }
  float masking_shadowing(Float3 to, Float3 from) const { return 1 / (1 + lambda(to) + lambda(from)); }
  // The BSDF for a Fresnel factor of 1; both directions above the surface, half their unit bisector.
  float reflection(Float3 to, Float3 from, Float3 half) const {
    return density(half) * masking_shadowing(to, from) / (4 * to.z * from.z);
  }
  // Density, per solid angle, of reflecting `to` at a normal from sample_half() that turns out to be `half`.
  float pdf(Float3 to, Float3 half) const { return density(half) * masking(to) / (4 * to.z); }
  // A microfacet normal among those seen from `to` (to.z > 0); u, v in [0, 1).
  Float3 sample_half(Float3 to, float u, float v) const;
};

// Directional albedo of a GGX lobe with Schlick's Fresnel term, E = f0 * at_normal + f90 * at_grazing, from a table
// made at first use (quadrature over visible normals, within 1e-3; alpha 0 in closed form). Thread-safe.
struct CoatAlbedo {
  float at_normal, at_grazing;
};
CoatAlbedo coat_albedo(float cosine, float roughness);
// The cosine-weighted mean over the hemisphere of exactly what coat_albedo() interpolates.
CoatAlbedo mean_coat_albedo(float roughness);

// Reflectance at grazing angles over that at normal incidence, where the latter is below 1/50: so that a coat fades
// away as its ior goes to 1, instead of leaving a rim (Lagarde and de Rousiers, Moving Frostbite to PBR,
// 2014, 3.1.3).
inline constexpr float kGrazingPerNormal = 50;

// What a hit knows of its material, textures read.
struct SurfaceMaterial {
  Float3 base{1, 1, 1};
  float metallic = 0, roughness = 1, transmission = 0, ior = 1.5f;
};

enum class Lobe { kNone, kDiffuse, kGlossy, kMirror, kRefraction };

struct BsdfValue {
  Float3 diffuse, glossy;                 // f * |cos(from)|, apart; sharp lobes not included
  float diffuse_pdf = 0, glossy_pdf = 0;  // of sample(), the choice of the lobe included
  Float3 value() const { return diffuse + glossy; }
  float pdf() const { return diffuse_pdf + glossy_pdf; }
};

struct BsdfSample {
  Float3 from;
  Float3 weight;            // f * |cos(from)| / pdf
  float pdf = 0;            // per solid angle, of all the lobes that are not sharp; 0 for a sharp lobe
  Lobe lobe = Lobe::kNone;  // kNone: the light ends here
};

// Which lobes a kernel was compiled for; material_lobes() of a material outside of it are not drawn.
struct LobeMask {
  bool diffuse = true, glossy = true, mirror = true, refraction = true;
};

// The scattering at one point, seen from `to`.
template <LobeMask kLobes = LobeMask{}>
class Bsdf {
 public:
  // to.z > 0. outside: `to` is on the front of the surface, that is outside of glass. lobes: those of kLobes that
  // are drawn. follow_diffuse: false stops sample() and the densities from following the matt base, whose light
  // then is what eval() says, no more.
  Bsdf(const SurfaceMaterial& material, Float3 to, bool outside, LobeMask lobes, bool follow_diffuse);

  // Both sides are `to`'s: from.z <= 0 gives 0.
  BsdfValue eval(Float3 from) const;
  // choose, u, v in [0, 1).
  BsdfSample sample(float choose, float u, float v) const;
  // eval() can be anything but 0.
  bool blurs() const { return has_diffuse() || (kLobes.glossy && ggx_.alpha > 0 && has_coat_); }
  // What sample() multiplied by eta's square to follow light through the surface, to undo it.
  float squeeze() const { return eta_ * eta_; }
  // Fraction of white light that is reflected or let through, roughly, in [0, 1]: what a denoiser calls albedo.
  Float3 albedo() const;

 private:
  bool has_diffuse() const { return kLobes.diffuse && max_component(matt_) > 0; }
  Float3 fresnel(float cosine) const { return f0_ + (f90_ - f0_) * schlick_weight(cosine); }
  float through_coat(float cosine) const;

  Float3 to_;
  SurfaceMaterial material_;
  Ggx ggx_{0};             // alpha 0: sharp
  bool has_coat_ = false;  // the coat or metal reflects
  Float3 f0_{}, f90_{};    // its reflectance at normal and grazing incidence, times its part of the surface
  float coat_f0_ = 0, coat_f90_ = 0;  // of the coat alone
  Float3 matt_{};                     // albedo of the matt base times its part, and times (1 - E(to)) / (1 - mean E)
  float mean_through_ = 1;            // 1 - mean E
  float glass_ = 0;                   // the part of the surface that is glass
  float glass_reflects_ = 0, glass_cos_t_ = 0, eta_ = 1;
  // Probabilities of following each lobe; their sum is 1, or 0 where nothing is followed.
  float follow_matt_ = 0, follow_coat_ = 0, follow_glass_ = 0;
};

template <LobeMask kLobes>
Bsdf<kLobes>::Bsdf(const SurfaceMaterial& material, Float3 to, bool outside, LobeMask lobes, bool follow_diffuse)
    : to_(to), material_(material) {
  const float metal = material.metallic, glass = material.transmission * (1 - metal);
  const float opaque = (1 - material.transmission) * (1 - metal);
  float matt_estimate = 0, coat_estimate = 0;
  const bool smooth = material.roughness < kSmoothRoughness;
  if ((kLobes.glossy && lobes.glossy && !smooth) || (kLobes.mirror && lobes.mirror && smooth)) {
    const float ratio = (material.ior - 1) / (material.ior + 1);
    coat_f0_ = material.ior == 0 ? 1 : ratio * ratio;
    coat_f90_ = std::min(1.f, coat_f0_ * kGrazingPerNormal);
    f0_ = material.base * metal + Float3{1, 1, 1} * (opaque * coat_f0_);
    f90_ = Float3{1, 1, 1} * (metal + opaque * coat_f90_);
    has_coat_ = max_component(f90_) > 0;
    ggx_.alpha = smooth ? 0 : material.roughness * material.roughness;
    if (has_coat_) {
      const CoatAlbedo coat = coat_albedo(to.z, smooth ? 0 : material.roughness);
      coat_estimate = max_component(f0_ * coat.at_normal + f90_ * coat.at_grazing);
    }
  }
  if (kLobes.diffuse && lobes.diffuse) {
    matt_ = material.base * opaque;
    if (coat_f90_ > 0) {
      const CoatAlbedo mean = mean_coat_albedo(smooth ? 0 : material.roughness);
      mean_through_ = 1 - (coat_f0_ * mean.at_normal + coat_f90_ * mean.at_grazing);
      matt_ *= mean_through_ > 1e-6f ? through_coat(to.z) / mean_through_ : 0;  // a perfect mirror hides its base
    }
    matt_estimate = follow_diffuse ? max_component(matt_) * mean_through_ : 0;
  }
  if (kLobes.refraction && lobes.refraction) {
    glass_ = glass;
    // An ior of 0 is glTF's way to ask for a mirror: light that may not leave a medium of infinite index.
    eta_ = outside ? material.ior : 1 / material.ior;
    glass_reflects_ = material.ior == 0 ? 1 : fresnel_dielectric(to.z, eta_, glass_cos_t_);
  }
  const float sum = matt_estimate + coat_estimate + glass_;
  if (!(sum > 0)) return;
  follow_matt_ = matt_estimate / sum;
  follow_coat_ = coat_estimate / sum;
  follow_glass_ = glass_ / sum;
}

template <LobeMask kLobes>
float Bsdf<kLobes>::through_coat(float cosine) const {
  if (coat_f90_ <= 0) return 1;
  const CoatAlbedo coat = coat_albedo(cosine, ggx_.alpha > 0 ? material_.roughness : 0);
  return 1 - (coat_f0_ * coat.at_normal + coat_f90_ * coat.at_grazing);
}

template <LobeMask kLobes>
BsdfValue Bsdf<kLobes>::eval(Float3 from) const {
  BsdfValue value;
  if (!(from.z > 0)) return value;
  if (has_diffuse()) {
    value.diffuse = matt_ * (through_coat(from.z) * from.z / kPi);
    value.diffuse_pdf = follow_matt_ * from.z / kPi;
  }
  if (kLobes.glossy && has_coat_ && ggx_.alpha > 0) {
    const Float3 half = normalise(to_ + from);
    value.glossy = fresnel(dot(to_, half)) * (ggx_.reflection(to_, from, half) * from.z);
    value.glossy_pdf = follow_coat_ * ggx_.pdf(to_, half);
  }
  return value;
}

template <LobeMask kLobes>
BsdfSample Bsdf<kLobes>::sample(float choose, float u, float v) const {
  BsdfSample sample;
  if (kLobes.diffuse && choose < follow_matt_) {
    const float radius = std::sqrt(u), angle = 2 * kPi * v;
    sample.from = {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1 - u)};
    sample.lobe = Lobe::kDiffuse;
  } else if ((kLobes.glossy || kLobes.mirror) && choose < follow_matt_ + follow_coat_) {
    if (kLobes.mirror && ggx_.alpha == 0) {
      sample.from = {-to_.x, -to_.y, to_.z};
      sample.weight = fresnel(to_.z) / follow_coat_;
      sample.lobe = Lobe::kMirror;
      return sample;
    }
    const Float3 half = ggx_.sample_half(to_, u, v);
    sample.from = half * (2 * dot(to_, half)) - to_;
    sample.lobe = Lobe::kGlossy;
  } else if (kLobes.refraction && follow_glass_ > 0) {
    sample.lobe = Lobe::kRefraction;
    const float within = std::clamp((choose - (1 - follow_glass_)) / follow_glass_, 0.f, 1.f);
    const float tint = max_component(material_.base), let_through = (1 - glass_reflects_) * tint;
    const float reflect =
        glass_reflects_ > 0 || let_through > 0 ? glass_reflects_ / (glass_reflects_ + let_through) : 1;
    if (within < reflect || let_through <= 0) {
      sample.from = {-to_.x, -to_.y, to_.z};
      sample.weight = Float3{1, 1, 1} * (glass_ * glass_reflects_ / (follow_glass_ * reflect));
    } else {
      sample.from = refract(to_, eta_, glass_cos_t_);
      // Radiance is squeezed by the square of the index: Veach, Robust Monte Carlo Methods, 1997, section 5.2.
      sample.weight =
          material_.base * (glass_ * (1 - glass_reflects_) / (follow_glass_ * (1 - reflect) * eta_ * eta_));
    }
    return sample;
  } else {
    return sample;
  }
  const BsdfValue value = eval(sample.from);
  sample.pdf = value.pdf();
  if (!(sample.pdf > 0)) return {};
  sample.weight = (follow_matt_ > 0 ? value.value() : value.glossy) / sample.pdf;
  return sample;
}

template <LobeMask kLobes>
Float3 Bsdf<kLobes>::albedo() const {
  Float3 sum = matt_ * mean_through_ + material_.base * glass_;
  if (has_coat_) {
    const CoatAlbedo coat = coat_albedo(to_.z, ggx_.alpha > 0 ? material_.roughness : 0);
    sum += f0_ * coat.at_normal + f90_ * coat.at_grazing;
  }
  return {std::min(sum.x, 1.f), std::min(sum.y, 1.f), std::min(sum.z, 1.f)};
}

}  // namespace triad::raytracer
