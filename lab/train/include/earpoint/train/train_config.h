#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <earpoint/train/example_loader.h>
#include <earpoint/train/vigas_learner.h>
#include <earpoint/vigas/description.h>

namespace earpoint {

/// How the learning rate changes over the run.
enum class Schedule {
  constant,
  cosine,  ///< falls to zero along half a cosine by the run's end
};

/// Whose weights become best.safetensors: of the validation with the smallest error, or of the
/// last, for losses that the error knows little of.
enum class Keep { best, last };

/// How long and how fast to learn.
struct TrainingPlan {
  std::uint64_t seed = 1;  ///< of weights and examples
  int batch = 8;           ///< clips a step, of all processes together
  std::int64_t steps = 0;
  std::optional<double> minutes;  ///< ends earlier; the schedule then follows the clock
  double learning_rate = 1e-3;
  Schedule schedule = Schedule::constant;
  std::int64_t warmup_steps = 0;      ///< the rate rises linearly over these
  std::int64_t validate_every = 200;  ///< steps; also when a checkpoint is written
  Keep keep = Keep::best;
  int patience = 0;  ///< validations without a better one until training ends; 0 never does
};

/// The rate of a step. @param step  from 0 on. @param progress  of the run, 0 to 1
[[nodiscard]] double learning_rate_at(const TrainingPlan& plan, std::int64_t step, double progress);

/// A configuration file: docs/formats.md has the keys.
struct TrainConfig {
  std::string kind;     ///< of network: "vigas", "gtf", ...
  std::string network;  ///< its section as JSON, for the kind's own parser
  std::string data;     ///< likewise
  TrainingPlan training;
  std::string text;  ///< the whole configuration with what it extends and what was set, as JSON
};

/// One value that replaces that of the configuration's file.
struct ConfigSetting {
  std::string key;    ///< names from the outside in, with dots: "network.picture.width_px"
  std::string value;  ///< JSON; what is no JSON is a string
};

/// Reads a configuration and the ones that it extends. Unknown keys are errors.
/// @param settings  override the file's values, later ones earlier ones
/// @param where     file and settings, for messages; empty: the file
/// @throws InputError naming file and key
[[nodiscard]] TrainConfig read_train_config(const std::filesystem::path& path,
                                            std::span<const ConfigSetting> settings = {},
                                            std::string where = {});

/// @param where  the file, for messages
[[nodiscard]] TrainConfig train_config_from_json(std::string_view json, std::string_view where);

/// Which weights a ViGAS network starts with.
enum class ViGasStart {
  released,  ///< initial_vigas_weights()
  identity,  ///< identity_vigas_weights()
  file,      ///< those of a weight file of the same description
};

/// The `network` section of kind "vigas".
struct ViGasConfig {
  ViGasDescription description;
  ViGasStart start = ViGasStart::identity;
  std::filesystem::path start_file;            ///< for ViGasStart::file
  std::optional<std::filesystem::path> trunk;  ///< a ResNet-18 for load_image_trunk()
  LossKind loss = LossKind::magnitude;
  /// Weight of the probe's loss: the conditioning vector must contain the speaker's position and
  /// how each ear's level changes: see LearnerOptions.
  double place = 0.0;
  std::int64_t place_steps = 0;  ///< likewise
};

/// @param json       the section; missing keys have the paper's values
/// @param separated  whether it learns sounds without ambient: part of the description
[[nodiscard]] ViGasConfig vigas_config_from_json(std::string_view json, std::string_view where,
                                                 bool separated);

/// The `data` section of networks that learn pairs of viewpoints.
[[nodiscard]] PairOptions pair_options_from_json(std::string_view json, std::string_view where);

}  // namespace earpoint
