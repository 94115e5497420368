#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <earpoint/serve/clip_library.h>
#include <earpoint/serve/listen_method.h>
#include <earpoint/serve/page_server.h>

namespace earpoint {

struct ServeOptions {
  PageAddress address{};
  int most_listeners = 8;
  /// Makes a clip of a file that somebody has dropped on the page; empty: they cannot. Called by
  /// one thread at a time. The name is what its sender calls it.
  std::function<ServedClip(const std::filesystem::path& file, const std::string& name)>
      open_upload{};
  std::size_t most_upload_bytes = std::size_t{256} << 20U;
};

/// Serves the page on which one walks through clips, and the sound of its listeners:
///
///   GET  /                        the page and its files
///   GET  /engine.wasm             the engine for browsers, if has_engine()
///   GET  /api/clips               {"clips": [{"id", "name"}], "most_upload_bytes", "has_engine"};
///                                 0 bytes: no uploads
///   POST /api/clips?name=NAME     a movie or a sound file -> {"clip": id}
///   GET  /api/clips/ID            what there is to hear, as JSON
///   GET  /api/clips/ID/picture    PNG
///   GET  /api/clips/ID/map        PNG, from above
///   GET  /api/clips/ID/sound      all of the recording: little-endian float32, the left ear, then
///                                 the right one
///   GET  /api/model?method=NAME   what the engine opens for a method that is "browser": "model" in
///                                 the clip's JSON
///   POST /api/clips/ID/walk?method=NAME&format=wav|mp4  CSV of a walk -> the rendered file
///   POST /api/listeners           {"clip": id} -> {"listener": name}; 503 if there is no room
///   POST /api/listeners/NAME/sound  {"start", "samples", "position_m", "yaw_deg", "pitch_deg",
///                                 "method", "matches_level"} -> float32, left and right in turns,
///                                 little-endian
///   POST /api/listeners/NAME/leave
///
/// What is refused is answered with {"error": one line}.
class ClipServer {
 public:
  /// @param library  must outlive it, and the methods too
  /// @throws InputError if the host is not this computer alone and there is no token
  ClipServer(ClipLibrary& library, std::span<const ListenMethod> methods, ServeOptions options);
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

/// Whether it holds the engine for browsers too: ./dev wasm had built it before.
[[nodiscard]] bool has_engine();

}  // namespace earpoint
