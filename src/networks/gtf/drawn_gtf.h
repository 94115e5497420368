#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/engine.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>

// Small networks that were never trained, for the tests of the engine.
namespace earpoint::gtf {

inline constexpr std::size_t kSamples = 8000;
inline constexpr std::size_t kHop = GtfDescription::kHop;
inline const Pose kHere{{1, 2, 0}, {}};
inline const Pose kThere{{-1, 0.5, 0}, quaternion_from_euler({.yaw_rad = 2})};

inline std::vector<float> noise(std::size_t count, double size, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(size * random.normal());
  return values;
}

inline GtfDescription small() {
  GtfDescription d;
  d.channels = 20;
  d.layers = 6;
  d.bands = 12;
  d.picture_px = 32;
  d.window_samples = kSamples;
  return d;
}

/// Random weights, and random levels and delays as the tables of the head.
inline GtfWeights random_weights(const GtfDescription& d) {
  GtfWeights weights{d, {}, {}};
  std::uint64_t seed = 1;
  for (const auto& [name, shape] : required_tensors(d)) {
    std::vector<float> values =
        noise(static_cast<std::size_t>(element_count(shape).value()), 0.1, seed++);
    if (name.find("power") != std::string::npos) {
      for (float& value : values) value = 0.5F + std::abs(value);
    }
    if (name == "head.delay_s") {
      for (float& value : values) value *= 1e-3F;
    }
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  return weights;
}

inline Gtf engine_that_looks(const GtfDescription& d) {
  Gtf engine(random_weights(d));
  engine.set_picture(noise(static_cast<std::size_t>(3 * d.picture_px * d.picture_px), 0.3, 5),
                     Box{0.1, 0.2, 0.3, 0.4});
  engine.set_pose({{1, 2, 0}, quaternion_from_euler({.yaw_rad = 0.3})});
  return engine;
}

/// Runs a planar sound through a stream that has begun. Calls before(hop) before each hop.
template <typename Before>
std::vector<float> streamed(Gtf& engine, std::span<const float> source, const Before& before) {
  const std::size_t samples = source.size() / 2;
  std::vector<float> result(source.size());
  std::vector<float> in(2 * kHop);
  std::vector<float> out(2 * kHop);
  for (std::size_t hop = 0; (hop + 1) * kHop <= samples; ++hop) {
    before(hop);
    for (std::size_t ear = 0; ear < 2; ++ear) {
      std::copy_n(source.begin() + ear * samples + hop * kHop, kHop, in.begin() + ear * kHop);
    }
    engine.advance(in, out);
    for (std::size_t ear = 0; ear < 2; ++ear) {
      std::copy_n(out.begin() + ear * kHop, kHop, result.begin() + ear * samples + hop * kHop);
    }
  }
  return result;
}

}  // namespace earpoint::gtf
