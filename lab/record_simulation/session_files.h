#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <earpoint/record/session.h>
#include <earpoint/record_simulation/session_plan.h>
#include <earpoint/record_simulation/session_simulation.h>

namespace earpoint {

/// Where the parts of one simulated session lie.
struct SessionFiles {
  SessionFiles(std::filesystem::path session_folder, const SessionPlan& plan);

  std::filesystem::path folder;
  std::filesystem::path session;
  std::filesystem::path truth;
  std::filesystem::path boxes;
  std::vector<std::filesystem::path> movies;       ///< by camera
  std::vector<std::filesystem::path> microphones;  ///< by person
  /// The cameras' sound before there are pictures; removed at the end.
  std::filesystem::path sound_folder;
  std::vector<std::filesystem::path> camera_sounds;

  [[nodiscard]] bool has_all() const;
  [[nodiscard]] bool has_sound() const;
};

/// Makes sure that a folder was begun with these options, or begins it.
/// @throws InputError naming the option that differs
void begin_simulation(const SessionSimulationOptions& options, const std::string& scene);

/// @param name   of the scene, e.g. "scenario-0003"
Session describe_session(const SessionFiles& files, const SessionPlan& plan,
                         const SessionPictureQuality& picture, std::string name, DataSplit split);

SessionTruth truth_of(const SessionPlan& plan);

}  // namespace earpoint
