#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/train/example_loader.h>
#include <earpoint/train/learner.h>
#include <earpoint/train/train_config.h>
#include <earpoint/vigas/description.h>

namespace earpoint {

/// What a Trainer runs: a learner and its examples.
struct TrainingTask {
  std::unique_ptr<Learner> learner;
  std::unique_ptr<ExampleLoader> examples;
};

struct TaskOptions {
  std::filesystem::path data;
  /// As PairOptions has it; networks that do not learn pairs of viewpoints refuse it.
  std::vector<std::filesystem::path> more_data{};
  std::optional<DatasetLayout> layout{};  ///< as PairOptions has it
  std::string device = "cpu";
  std::size_t cache_bytes = std::size_t{2} << 30;
  /// As PairOptions has it.
  std::function<void(const std::string&)> on_bad;
  /// Where to go on from, or nothing to begin. @see Trainer
  const SafetensorsFile* checkpoint = nullptr;
};

/// Makes the network and its examples that a configuration describes.
/// @param where  the configuration's file, for messages
/// @throws InputError naming the key or the file that is wrong
[[nodiscard]] TrainingTask make_training_task(const TrainConfig& config, std::string_view where,
                                              const TaskOptions& options);

/// A sample as a ViGAS network is trained on it: beside its inputs it holds, as "place", cosine and
/// sine of the speaker's azimuth at the target, the logarithm of the distance there in metres, and
/// that of this distance over the source's.
[[nodiscard]] TrainingExample vigas_example(const ViGasDescription& description,
                                            const PairSample& sample);

}  // namespace earpoint
