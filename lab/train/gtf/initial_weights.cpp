#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/core/ears.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/pose.h>
#include <earpoint/train/gtf_learner.h>

namespace earpoint {
namespace {

using D = GtfDescription;
using Shape = std::vector<std::int64_t>;

using BandPowers = std::array<double, D::kHeadBands>;

/// Mean power of a response in each band of the tables.
BandPowers band_powers(std::span<const float> response) {
  std::vector<float> padded(response.begin(), response.end());
  padded.resize(static_cast<std::size_t>(
      fast_fft_size(std::max<int>(D::kFftSize, static_cast<int>(response.size())))));
  RealFft<float> fft(static_cast<int>(padded.size()));
  std::vector<std::complex<float>> spectrum(static_cast<std::size_t>(fft.bins()));
  fft.forward(padded, spectrum);
  BandPowers powers{};
  // A longer transform has more bins in a band.
  const double finer = static_cast<double>(padded.size()) / D::kFftSize;
  for (int band = 0; band < D::kHeadBands; ++band) {
    const auto first = static_cast<std::size_t>(std::lround(kGtfHeadEdges[band] * finer));
    const auto last = std::min(
        static_cast<std::size_t>(std::lround(kGtfHeadEdges[band + 1] * finer)), spectrum.size());
    for (std::size_t bin = first; bin < last; ++bin) powers[band] += std::norm(spectrum[bin]);
    powers[band] /= static_cast<double>(last - first);
  }
  return powers;
}

/// Power and onset of the horizontal plane.
void fill_directions(const HrtfSet& head, std::vector<float>& power, std::vector<float>& delay_s) {
  double mean_s = 0.0;
  for (int step = 0; step < D::kHeadAzimuths; ++step) {
    const double azimuth_rad = 2.0 * kPi * step / D::kHeadAzimuths;
    const Hrir hrir = head.interpolated({std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0});
    for (int ear = 0; ear < kEars; ++ear) {
      for (const double value : band_powers(hrir.taps[ear])) {
        power.push_back(static_cast<float>(value));
      }
      delay_s.push_back(static_cast<float>(hrir.onset_samples[ear] / D::kSampleRateHz));
      mean_s += delay_s.back();
    }
  }
  mean_s /= static_cast<double>(delay_s.size());
  for (float& delay : delay_s) delay -= static_cast<float>(mean_s);
}

/// Mean power over directions spread evenly over the sphere.
std::vector<float> diffuse_powers(const HrtfSet& head) {
  constexpr int kDirections = 200;
  const double golden_angle_rad = kPi * (3.0 - std::sqrt(5.0));
  std::vector<float> powers(kEars * D::kHeadBands);
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections;
    const double level = std::sqrt(1.0 - z * z);
    const Vector3 direction{level * std::cos(golden_angle_rad * i),
                            level * std::sin(golden_angle_rad * i), z};
    const Hrir hrir = head.interpolated(direction);
    for (int ear = 0; ear < kEars; ++ear) {
      const BandPowers of_ear = band_powers(hrir.taps[ear]);
      for (int band = 0; band < D::kHeadBands; ++band) {
        powers[ear * D::kHeadBands + band] += static_cast<float>(of_ear[band] / kDirections);
      }
    }
  }
  return powers;
}

void add_head_tables(const HrtfSet& head, std::map<std::string, Tensor>& tensors) {
  EARPOINT_CHECK(head.sample_rate_hz() == D::kSampleRateHz);
  std::vector<float> power;
  std::vector<float> delay_s;
  fill_directions(head, power, delay_s);
  tensors["head.power"] = make_tensor<float>(power, {D::kHeadAzimuths, kEars, D::kHeadBands});
  tensors["head.delay_s"] = make_tensor<float>(delay_s, {D::kHeadAzimuths, kEars});
  tensors["head.diffuse_power"] = make_tensor<float>(diffuse_powers(head), {kEars, D::kHeadBands});
}

/// Kernels that pass each ear's own frame unchanged.
std::vector<float> identity_kernels(const D& d) {
  std::vector<float> bias(static_cast<std::size_t>(kEars) * kEars * d.taps() * d.bands);
  for (int ear = 0; ear < kEars; ++ear) {
    const int row = ((ear * kEars + ear) * d.taps() + d.past_frames) * d.bands;
    std::fill_n(bias.begin() + row, d.bands, 1.0F);
  }
  return bias;
}

bool starts_at_zero(std::string_view name) {
  return name.starts_with("kernel.static.") || name.starts_with("gain.") ||
         name.starts_with("dry.") || name.starts_with("phase.") || name == "kernel.bias" ||
         name.ends_with(".norm.bias");
}

/// 1 / sqrt(inputs of one output of the layer).
double bound_of(const std::map<std::string, Shape>& shapes, const std::string& name) {
  const Shape& weight = shapes.at(name.substr(0, name.rfind('.')) + ".weight");
  double inputs = 1.0;
  for (std::size_t axis = 1; axis < weight.size(); ++axis) {
    inputs *= static_cast<double>(weight[axis]);
  }
  return 1.0 / std::sqrt(inputs);
}

std::vector<float> draw(const std::map<std::string, Shape>& shapes, const std::string& name,
                        RandomStream random) {
  constexpr double kKernelDeviation = 0.002;
  std::vector<float> values(static_cast<std::size_t>(element_count(shapes.at(name)).value()));
  if (starts_at_zero(name)) return values;
  if (name.ends_with(".norm.weight")) return std::vector<float>(values.size(), 1.0F);
  if (name == "kernel.weight") {
    for (float& value : values) value = static_cast<float>(kKernelDeviation * random.normal());
    return values;
  }
  const double bound = bound_of(shapes, name);
  for (float& value : values) value = static_cast<float>(random.uniform(-bound, bound));
  return values;
}

}  // namespace

GtfWeights initial_gtf_weights(const GtfDescription& description, const HrtfSet& head,
                               std::uint64_t seed) {
  GtfWeights weights{description, {}, {}};
  if (description.geometry) add_head_tables(head, weights.tensors);
  const std::map<std::string, Shape> shapes = required_tensors(description);
  std::uint64_t index = 0;
  for (const auto& [name, shape] : shapes) {
    const RandomStream random(seed, {index++});
    if (is_gtf_table(name)) continue;
    weights.tensors[name] = make_tensor<float>(
        name == "kernel.bias" ? identity_kernels(description) : draw(shapes, name, random), shape);
  }
  return weights;
}

GtfWeights with_new_parts(GtfWeights weights, const GtfDescription& description,
                          std::uint64_t seed) {
  GtfDescription& d = weights.description;
  const GtfDescription before = d;
  const std::int64_t known = before.conditioning_inputs() - before.sight_features();
  d.ear_delays |= description.ear_delays;
  d.expected_level |= description.expected_level;
  d.texture |= description.texture;
  d.dry_voice |= description.dry_voice;
  if (d.phase_rounds == 0) d.phase_rounds = description.phase_rounds;
  if (d.sight_points == 0) d.sight_points = description.sight_points;
  check_description(d, "new parts");
  const std::map<std::string, Shape> shapes = required_tensors(d);
  std::uint64_t index = 0;
  for (const auto& [name, shape] : shapes) {
    const RandomStream random(seed, {index++});
    if (weights.tensors.contains(name)) continue;
    weights.tensors[name] = make_tensor<float>(draw(shapes, name, random), shape);
  }
  // The texture's condition comes before those of the sight points; new ones have weights of zero.
  Tensor& joined = weights.tensors.at("conditioning.0.weight");
  const Shape& wider = shapes.at("conditioning.0.weight");
  const std::int64_t inserted = d.texture && !before.texture ? 1 : 0;
  std::vector<float> values(static_cast<std::size_t>(wider[0] * wider[1]));
  for (std::int64_t row = 0; row < wider[0]; ++row) {
    const auto from = joined.as<float>().begin() + row * before.conditioning_inputs();
    const auto to = values.begin() + row * wider[1];
    std::copy_n(from, known, to);
    std::copy_n(from + known, before.sight_features(), to + known + inserted);
  }
  joined = make_tensor<float>(values, wider);
  return weights;
}

}  // namespace earpoint
