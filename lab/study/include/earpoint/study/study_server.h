#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace earpoint {

struct StudyServerOptions {
  std::string host = "127.0.0.1";
  int port = 0;         ///< 0: any that is free
  std::string token{};  ///< what every request must bring; empty: this computer alone is answered
};

/// Serves a study's page and takes its answers (StudyDesk says what is in them), by a PageServer:
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
  /// @throws InputError as StudyDesk, as PageServer
  explicit StudyServer(const std::filesystem::path& folder, const StudyServerOptions& options = {});
  ~StudyServer();

  /// @return the port
  /// @throws InputError if the address cannot be had
  int bind();
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
