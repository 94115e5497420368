#include "run_folder.h"

#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/network/weights.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kCheckpoint = "checkpoint.safetensors";
constexpr const char* kStateKey = "earpoint.training";
constexpr const char* kConfigKey = "earpoint.training_config";

std::string text_of(const RunState& state) {
  return Json{{"step", state.step},
              {"seconds", state.seconds},
              {"step_seconds", state.step_seconds},
              {"first_error", state.first_error},
              {"best_error", state.best_error},
              {"best_step", state.best_step},
              {"validations_since_best", state.validations_since_best}}
      .dump();
}

/// A configuration without the values that may change when a run is resumed.
Json without_limits(const std::string& config) {
  Json json = Json::parse(config, nullptr, false);
  if (!json.is_object()) return json;
  for (const char* key : {"steps", "minutes", "patience"}) json["training"].erase(key);
  return json;
}

}  // namespace

RunLock::RunLock(const fs::path& folder) : lock_(create_folder(folder) / ".lock") {
  if (lock_.try_lock(0, 1)) return;
  throw InputError(folder.string(), "another process is training there",
                   "wait for it, or choose another output folder");
}

RunState run_state_in(const SafetensorsFile& checkpoint) {
  const auto found = checkpoint.metadata.find(kStateKey);
  if (found == checkpoint.metadata.end()) {
    throw InputError(kCheckpoint, fmt::format("has no '{}'", kStateKey), "start a new run");
  }
  try {
    const Json json = Json::parse(found->second);
    return {.step = json.at("step"),
            .seconds = json.at("seconds"),
            .step_seconds = json.at("step_seconds"),
            .first_error = json.at("first_error"),
            .best_error = json.at("best_error"),
            .best_step = json.at("best_step"),
            .validations_since_best = json.at("validations_since_best")};
  } catch (const Json::exception&) {
    throw InputError(kCheckpoint, fmt::format("its '{}' is malformed", kStateKey),
                     "start a new run");
  }
}

RunFolder::RunFolder(const TrainerOptions& options, std::int64_t last_step)
    : options_(options),
      steps_(create_folder(options.folder) / "steps.csv", "step,loss,learning_rate", last_step),
      validations_(options.folder / "validation.csv", "step,clips,seconds,loss,error", last_step) {
  write_file(options.folder / "config.json", options.config);
}

void RunFolder::add_step(std::int64_t step, double loss, double learning_rate) {
  steps_.add({static_cast<double>(step), loss, learning_rate});
}

void RunFolder::add_validation(const ValidationResult& result) {
  validations_.add({static_cast<double>(result.step), static_cast<double>(result.clips),
                    result.seconds, result.loss, result.error});
}

double RunFolder::recent_loss() const {
  const double since = validations_.rows().empty() ? 0.0 : validations_.rows().back()[0];
  double sum = 0.0;
  std::int64_t count = 0;
  const auto& rows = steps_.rows();
  for (auto row = rows.rbegin(); row != rows.rend() && (*row)[0] > since; ++row, ++count) {
    sum += (*row)[1];
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

void RunFolder::save(const Learner& learner, const RunState& state, bool is_kept) {
  steps_.flush();
  validations_.flush();
  if (is_kept) {
    SafetensorsFile weights = learner.weight_file();
    weights.metadata[kConfigKey] = options_.config;
    weights.metadata[kStateKey] = text_of(state);
    write_safetensors(options_.folder / "best.safetensors", weights);
  }
  SafetensorsFile checkpoint = learner.checkpoint();
  checkpoint.metadata[kConfigKey] = options_.config;
  checkpoint.metadata[kStateKey] = text_of(state);
  write_safetensors(options_.folder / kCheckpoint, checkpoint);
  draw_curves(std::string(learner.error_name()));
}

void RunFolder::draw_curves(const std::string& error_name) const {
  std::vector<CurvePoint> losses;
  for (const auto& row : steps_.rows()) losses.push_back({row[0] * options_.plan.batch, row[1]});
  std::vector<CurvePoint> errors;
  for (const auto& row : validations_.rows()) errors.push_back({row[1], row[4]});
  write_image(options_.folder / "curves.png", plot_training(losses, errors, error_name));
}

std::optional<SafetensorsFile> read_checkpoint(const fs::path& folder, const std::string& config) {
  const fs::path path = folder / kCheckpoint;
  if (!fs::exists(path)) return std::nullopt;
  SafetensorsFile checkpoint = read_safetensors(path);
  const auto found = checkpoint.metadata.find(kConfigKey);
  if (found == checkpoint.metadata.end() ||
      without_limits(found->second) != without_limits(config)) {
    throw InputError(path.string(), "belongs to a run with another configuration",
                     fmt::format("see {}", (folder / "config.json").string()));
  }
  return checkpoint;
}

}  // namespace earpoint
