#pragma once

#include <filesystem>
#include <memory>

namespace earpoint {

/// Serves a study's page and takes its answers, to this computer alone (StudyDesk says what is in
/// them):
///
///   GET  /                                   the page and its files
///   GET  /api/study
///   POST /api/participants
///   GET  /api/participants/ID
///   GET  /api/participants/ID/steps/N/picture            PNG
///   GET  /api/participants/ID/steps/N/sounds/SOUND       WAV; SOUND is "reference" or a number
///   POST /api/participants/ID/steps/N
///   POST /api/participants/ID/finish
class StudyServer {
 public:
  /// @throws InputError as StudyDesk
  explicit StudyServer(const std::filesystem::path& folder);
  ~StudyServer();

  /// @param port  of 127.0.0.1; 0 takes any that is free
  /// @return the port
  /// @throws InputError if it cannot be had
  int bind(int port);
  /// Serves until stop(); after bind().
  void run();
  /// From any thread.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether this build holds the page: esbuild was there when it was configured.
[[nodiscard]] bool has_study_page();

}  // namespace earpoint
