// The error of an estimator of reverberation time on a data set's speech: the mean absolute error
// over all responses of a split, each with one random second of that split's voices. Writes one
// JSON object to standard output.
//
// usage: rt60_error DATA [SPLIT [MODEL]]     default: the test split and the shipped model

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset/reverberant_speech.h>
#include <earpoint/error.h>
#include <earpoint/network/shipped_model.h>
#include <earpoint/rt60/engine.h>
#include <earpoint/rt60/weights.h>

namespace {

using namespace earpoint;

constexpr std::uint64_t kSeed = 1;
// The range of T60 for which the error is stated, and the steps of its table.
constexpr double kShortestS = 0.2;
constexpr double kLongestS = 1.0;
constexpr std::size_t kSteps = 8;

struct Estimate {
  double true_s = 0.0;
  double found_s = 0.0;
};

std::vector<Estimate> estimate_all(const ReverberantSpeech& speech, Rt60Estimator& estimator) {
  std::vector<Estimate> estimates;
  for (std::size_t i = 0; i < speech.responses(); ++i) {
    RandomStream random(kSeed, {i});
    const ReverberantSecond second = speech.measured(i, random);
    if (second.t60_s < kShortestS || second.t60_s > kLongestS) continue;
    estimates.push_back({second.t60_s, estimator.estimate_second_s(second.sound)});
  }
  return estimates;
}

double mean_error(const std::vector<Estimate>& estimates) {
  double sum = 0.0;
  for (const Estimate& e : estimates) sum += std::abs(e.found_s - e.true_s);
  return sum / static_cast<double>(estimates.size());
}

/// The same for an estimator that always returns the median.
double median_error(std::vector<Estimate> estimates) {
  std::ranges::sort(estimates, {}, &Estimate::true_s);
  const double median_s = estimates[estimates.size() / 2].true_s;
  for (Estimate& e : estimates) e.found_s = median_s;
  return mean_error(estimates);
}

nlohmann::ordered_json table(const std::vector<Estimate>& estimates) {
  std::array<std::vector<Estimate>, kSteps> steps;
  constexpr double kWidthS = (kLongestS - kShortestS) / kSteps;
  for (const Estimate& e : estimates) {
    const auto step = static_cast<std::size_t>((e.true_s - kShortestS) / kWidthS);
    steps[std::min(step, kSteps - 1)].push_back(e);
  }
  auto rows = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < kSteps; ++i) {
    if (steps[i].empty()) continue;
    rows.push_back({{"from_s", kShortestS + static_cast<double>(i) * kWidthS},
                    {"responses", steps[i].size()},
                    {"error_s", mean_error(steps[i])}});
  }
  return rows;
}

void measure(const std::string& data, const std::string& split,
             const std::filesystem::path& model) {
  const SoundSpacesDataset dataset(soundspaces_options(data, split));
  const ReverberantSpeech speech(dataset);
  Rt60Estimator estimator(read_rt60_estimator_weights(model));
  const std::vector<Estimate> estimates = estimate_all(speech, estimator);
  if (estimates.empty()) throw InputError(data, "has no response that decays in 0.2 to 1.0 s");
  double bias = 0.0;
  for (const Estimate& e : estimates) bias += e.found_s - e.true_s;
  const nlohmann::ordered_json json = {{"split", split},
                                       {"responses", estimates.size()},
                                       {"error_s", mean_error(estimates)},
                                       {"bias_s", bias / static_cast<double>(estimates.size())},
                                       {"error_of_saying_the_median_s", median_error(estimates)},
                                       {"by_time", table(estimates)}};
  fmt::print("{}\n", json.dump(2));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    fmt::print(stderr, "usage: rt60_error DATA [SPLIT [MODEL]]\n");
    return 2;
  }
  try {
    std::optional<std::filesystem::path> model = shipped_model_path("rt60.safetensors");
    if (argc > 3) model = argv[3];
    if (!model) throw InputError("models/rt60.safetensors", "is not there", "name a model");
    measure(argv[1], argc > 2 ? argv[2] : "test", *model);
  } catch (const std::exception& error) {
    fmt::print(stderr, "rt60_error: {}\n", error.what());
    return 1;
  }
  return 0;
}
