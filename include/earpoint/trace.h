#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <earpoint/error.h>
#include <earpoint/export.h>
#include <earpoint/pose.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Kind of receiver in a traced scene.
enum class TraceMicrophone {
  ears,  ///< two ears of the KEMAR head: a binaural room impulse response, left first
  omni,  ///< one omnidirectional microphone
};

/// Source, receiver and quality of a response.
struct TraceRequest {
  Pose source{};    ///< world_from_source; its front matters only for a talker
  Pose listener{};  ///< world_from_listener
  TraceMicrophone microphone = TraceMicrophone::ears;
  bool talks = false;          ///< the source has a talker's directivity, louder in front
  int sample_rate_hz = 48000;  ///< from 8000 to 192000
  double duration_s = 1.0;     ///< of the response, from 0.01 to 30
  int rays = 5000;             ///< from the source, > 0
  std::uint64_t seed = 1;      ///< the same seed gives the same samples
  int threads = 1;             ///< > 0; the samples are the same for any number
};

/// A scene to trace sound in. Const calls may be made from many threads at once.
class EARPOINT_API TraceScene {
 public:
  /// Reads a glTF 2.0 (.gltf, .glb), Wavefront (.obj) or Stanford (.ply) model. Acoustic
  /// materials are the standard ones, by material name.
  /// @throws InputError if the file is missing, damaged, or no scene of 0.5 m to 1 km
  [[nodiscard]] static TraceScene open(const std::filesystem::path& model);

  /// An empty box with a corner at the origin.
  /// @param lengths_m   along x, y, z; > 0
  /// @param absorption  of all faces at all frequencies, 0 to 1
  /// @param scattering  the same
  [[nodiscard]] static TraceScene box(const Vector3& lengths_m, double absorption,
                                      double scattering = 0.1);

  ~TraceScene();
  TraceScene(TraceScene&&) noexcept;
  TraceScene& operator=(TraceScene&&) noexcept;

  /// What the importer assumed or left out: messages, a line each.
  [[nodiscard]] const std::vector<std::string>& warnings() const;

  /// The impulse response from the source to the listener, as `earpoint trace` writes it. 1 is the
  /// level of the source at 1 m in free field; the travel time is included.
  /// @throws InputError if source or listener are outside the scene or less than 1 mm apart, a
  ///         number is out of range, or no sound arrives
  [[nodiscard]] Waveform response(const TraceRequest& request) const;

 private:
  struct State;
  explicit TraceScene(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
