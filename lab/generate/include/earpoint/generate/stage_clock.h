#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace earpoint {

/// What the time of a simulation goes into.
enum class Stage { scene, plan, acoustics, trace, responses, light, pictures, speech, writing };
inline constexpr int kStages = 9;

std::string_view name_of(Stage stage);

/// Counts processor time by stage: that of the calling thread, so waiting for others is not in it.
class StageClock {
 public:
  StageClock();

  /// What has passed since the last call, or since the clock was made, went into this stage.
  void charge(Stage stage);

  /// Adds another's times.
  void add(const StageClock& other);

  [[nodiscard]] double seconds(Stage stage) const {
    return seconds_[static_cast<std::size_t>(stage)];
  }

 private:
  double last_s_;
  std::array<double, kStages> seconds_{};
};

}  // namespace earpoint
