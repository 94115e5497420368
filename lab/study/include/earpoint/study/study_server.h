#pragma once

#include <filesystem>
#include <memory>

#include <earpoint/serve/page_server.h>

namespace earpoint {

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
  explicit StudyServer(const std::filesystem::path& folder, const PageAddress& address = {});
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
