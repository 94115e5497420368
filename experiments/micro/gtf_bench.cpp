// One second of sound through the geometric time-frequency network and through the released ViGAS
// network, alternately, and the multiply-adds of each. Prints JSON.
//
// usage: gtf_bench [--rounds N]
#include "released_network.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <earpoint/core/random.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/engine.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/engine.h>

namespace {

using earpoint::Gtf;
using earpoint::GtfDescription;

std::vector<float> noise(std::size_t count, double size, std::uint64_t seed) {
  earpoint::RandomStream random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(size * random.normal());
  return values;
}

/// The network of configs/gtf.json.
GtfDescription configured() {
  GtfDescription description;
  description.channels = 128;
  description.future_frames = 1;
  description.look_ahead_frames = 1;
  description.phase_rounds = 2;
  description.texture = true;
  description.dry_voice = true;
  return description;
}

/// Random weights: their values do not change the time.
earpoint::GtfWeights drawn_network(const GtfDescription& description) {
  earpoint::GtfWeights weights{description, {}, {}};
  std::uint64_t seed = 1;
  for (const auto& [name, shape] : required_tensors(description)) {
    std::vector<float> values =
        noise(static_cast<std::size_t>(earpoint::element_count(shape).value()), 0.05, seed++);
    if (name.find("power") != std::string::npos) {
      for (float& value : values) value = 1.0F + value;
    }
    weights.tensors[name] = earpoint::make_tensor<float>(values, shape);
  }
  return weights;
}

/// Millions of multiply-adds for a second of sound: layers that see every frame, and the kernels.
double gtf_millions(const earpoint::GtfWeights& weights) {
  double of_frame = 4.0 * weights.description.taps() * GtfDescription::kBins;
  for (const auto& [name, tensor] : weights.tensors) {
    const bool is_per_frame = name == "kernel.weight" || name == "gain.weight" ||
                              (name.starts_with("trunk.") && name.ends_with(".weight") &&
                               name.find(".film.") == std::string::npos);
    if (is_per_frame) of_frame += static_cast<double>(tensor.elements());
  }
  return of_frame * GtfDescription::kSampleRateHz / GtfDescription::kHop * 1e-6;
}

/// The same for the gated stack, in its direct form.
double vigas_millions(const earpoint::ViGasDescription& d) {
  const double squared = static_cast<double>(d.channels) * d.channels;
  return d.layers() * squared * (2.0 * d.kernel_size + 2.0) * d.sample_rate_hz * 1e-6;
}

template <typename Work>
double seconds_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void run(int rounds) {
  const GtfDescription description = configured();
  const earpoint::GtfWeights weights = drawn_network(description);
  Gtf gtf(weights);
  const std::vector<float> picture =
      noise(std::size_t{3} * static_cast<std::size_t>(description.picture_px) *
                static_cast<std::size_t>(description.picture_px),
            0.3, 3);
  const std::vector<float> second = noise(std::size_t{2} * 16000, 0.1, 4);
  std::vector<float> output(second.size());
  std::vector<float> hop(std::size_t{2} * GtfDescription::kHop);

  const earpoint::ViGasWeights released = earpoint::released_network();
  earpoint::ViGas vigas(released, 2);
  const std::vector<float> fused =
      noise(static_cast<std::size_t>(released.description.conditioning_width), 0.3, 5);

  std::vector<double> window_s;
  std::vector<double> picture_s;
  std::vector<double> moving_s;
  std::vector<double> vigas_s;
  for (int round = 0; round < rounds; ++round) {
    picture_s.push_back(seconds_of([&] { gtf.set_picture(picture, {}); }));
    gtf.set_pose({{1, 0, 0}, {}});
    window_s.push_back(seconds_of([&] { gtf.synthesize(second, output); }));
    // A stream whose target moves at every hop.
    gtf.start();
    moving_s.push_back(seconds_of([&] {
      for (int i = 0; i < 100; ++i) {
        gtf.set_pose({{0.01 * i, 0, 0}, {}});
        gtf.advance(std::span(second).subspan(static_cast<std::size_t>(i) * hop.size(), hop.size()),
                    hop);
      }
    }));
    vigas_s.push_back(seconds_of([&] { vigas.synthesize(second, fused, output); }));
  }
  fmt::print(R"({{"gtf": {{"threads": 1, "million_multiply_adds": {:.1f}, "window_s": {:.5f}, )"
             R"("picture_s": {:.5f}, "moving_stream_s": {:.5f}, "times_real_time": {:.1f}, )"
             R"("moving_times_real_time": {:.1f}}},)"
             "\n"
             R"( "vigas": {{"threads": 2, "million_multiply_adds": {:.1f}, "window_s": {:.5f}, )"
             R"("times_real_time": {:.2f}}}}})"
             "\n",
             gtf_millions(weights), median(window_s), median(picture_s), median(moving_s),
             1.0 / (median(window_s) + median(picture_s)), 1.0 / median(moving_s),
             vigas_millions(released.description), median(vigas_s), 1.0 / median(vigas_s));
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  run(arguments.size() == 2 && arguments[0] == "--rounds" ? std::stoi(arguments[1]) : 20);
  return 0;
}
