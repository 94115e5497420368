#pragma once

#include <memory>
#include <string>

#include <earpoint/serve/served_clip.h>

namespace earpoint {

struct ServeOptions {
  std::string host = "127.0.0.1";
  int port = 0;  ///< 0: any that is free
  int most_listeners = 8;
};

/// Serves the page on which one walks through a clip, and the sound of its listeners:
///
///   GET  /                        the page and its files
///   GET  /api/clip                what there is to hear, as JSON
///   GET  /api/picture             PNG
///   POST /api/listeners           {"listener": name}; 503 if there is no room
///   POST /api/listeners/NAME/sound  {"start", "samples", "position_m", "yaw_deg", "pitch_deg",
///                                 "method"} -> float32, left and right in turns, little-endian
///
/// Answers only requests that name this host (no page of another site can reach it).
class ClipServer {
 public:
  /// @param clip  must outlive it
  ClipServer(const ServedClip& clip, const ServeOptions& options);
  ~ClipServer();

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
[[nodiscard]] bool has_page();

}  // namespace earpoint
