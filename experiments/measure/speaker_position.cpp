// How far the speaker is from where a gtf network locates them by one picture and one second of
// sound, on the frozen pairs of a split: told the true box, and told nothing. Writes one JSON
// object to standard output.
//
// usage: speaker_position DATA [SPLIT [MODEL]]     default: the test split and the shipped gtf

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <earpoint/error.h>
#include <earpoint/evaluate/evaluation_set.h>
#include <earpoint/gtf/engine.h>
#include <earpoint/gtf/view.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/network/shipped_model.h>
#include <earpoint/pose.h>

namespace {

using namespace earpoint;

constexpr std::size_t kCacheBytes = std::size_t{256} << 20;

/// Errors of every pair.
struct Errors {
  std::vector<double> azimuth_deg;
  std::vector<double> distance_ratio;  ///< the larger over the smaller, less one
  std::vector<double> heading_deg;     ///< of the way the speaker faces
};

/// Of two angles, 0 to 180.
double degrees_between(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, 2.0 * kPi)) * 180.0 / kPi;
}

void add(Errors& errors, const GtfSpeaker& found, const PairSample& sample) {
  const Vector3& at = found.position_m;
  const Vector3& truth = sample.speaker_m;
  errors.azimuth_deg.push_back(
      degrees_between(std::atan2(at.y, at.x), std::atan2(truth.y, truth.x)));
  errors.distance_ratio.push_back(std::exp(std::abs(std::log(norm(at) / norm(truth)))) - 1.0);
  errors.heading_deg.push_back(degrees_between(found.yaw_rad, *sample.speaker_yaw_rad));
}

Errors errors_of(const EvaluationSet& pairs, Gtf& gtf, bool is_told_box) {
  Errors errors;
  for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
    const PairSample sample = pairs.sample(pair);
    if (!sample.speaker_yaw_rad) continue;
    const GtfView view =
        gtf_view(sample.picture.get(), is_told_box ? sample.speaker_box : std::nullopt,
                 sample.horizontal_fov_rad, gtf.description().picture_px);
    gtf.set_picture(view.picture, view.speaker_box);
    if (const auto found = gtf.locate(sample.source.planar())) add(errors, *found, sample);
  }
  return errors;
}

nlohmann::ordered_json quantiles(std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  return {{"median", at(0.5)}, {"three_quarters", at(0.75)}, {"nine_tenths", at(0.9)}};
}

void measure(const std::string& data, const std::string& split,
             const std::filesystem::path& model) {
  const auto pairs = soundspaces_evaluation_set(data, split, {}, std::nullopt, kCacheBytes);
  Gtf gtf(read_gtf_weights(model));
  if (gtf.description().picture_px == 0) throw InputError(model.string(), "takes no picture");
  nlohmann::ordered_json json = {{"split", split}, {"rows", nlohmann::ordered_json::array()}};
  for (const bool is_told_box : {true, false}) {
    const Errors errors = errors_of(*pairs, gtf, is_told_box);
    if (errors.azimuth_deg.empty()) throw InputError(data, "has no pair with a known speaker");
    json["rows"].push_back({{"box", is_told_box},
                            {"pairs", errors.azimuth_deg.size()},
                            {"azimuth_deg", quantiles(errors.azimuth_deg)},
                            {"distance_ratio", quantiles(errors.distance_ratio)},
                            {"heading_deg", quantiles(errors.heading_deg)}});
  }
  fmt::print("{}\n", json.dump(2));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    fmt::print(stderr, "usage: speaker_position DATA [SPLIT [MODEL]]\n");
    return 2;
  }
  try {
    std::optional<std::filesystem::path> model = shipped_model_path("gtf.safetensors");
    if (argc > 3) model = argv[3];
    if (!model) throw InputError("models/gtf.safetensors", "is not there", "name a model");
    measure(argv[1], argc > 2 ? argv[2] : "test", *model);
  } catch (const std::exception& error) {
    fmt::print(stderr, "speaker_position: {}\n", error.what());
    return 1;
  }
  return 0;
}
