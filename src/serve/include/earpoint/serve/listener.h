#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include <earpoint/core/pose.h>
#include <earpoint/core/waveform.h>
#include <earpoint/serve/served_clip.h>
#include <earpoint/synth/render_stream.h>

namespace earpoint {

/// What a listener hears of a clip.
enum class ListenMethod {
  input,  ///< the recording itself
  gtf,
};

/// @return the method of that name; nothing if there is none
[[nodiscard]] std::optional<ListenMethod> listen_method(std::string_view name);

/// Somebody who walks through a clip: asks for its sound part by part, each from where they are
/// then. A recording can be read ahead, so that no latency of the network remains.
class Listener {
 public:
  /// @param clip  must outlive it
  explicit Listener(const ServedClip& clip);

  /// What is heard from sample `start` on, at the clip's rate. Parts that follow one another join;
  /// a leap takes half a second of the sound before to warm up. From the pose of the part before
  /// the head moves to this one evenly, and methods fade into each other.
  /// @param samples  1 to the clip's rate; beyond the clip there is silence
  /// @throws InputError if the pose is not finite or absurdly far
  [[nodiscard]] Waveform listen(std::ptrdiff_t start, std::ptrdiff_t samples,
                                const Pose& source_from_target, ListenMethod method);

 private:
  void leap(std::ptrdiff_t start, const Pose& pose);
  [[nodiscard]] Waveform source(std::ptrdiff_t start, std::ptrdiff_t samples) const;
  [[nodiscard]] Waveform rendered(std::ptrdiff_t start, std::ptrdiff_t samples, const Pose& pose);

  const ServedClip& clip_;
  RenderStream stream_;
  std::ptrdiff_t next_ = -1;  ///< the sample that a part must begin with to join the last one
  Pose pose_;
  ListenMethod method_ = ListenMethod::gtf;
};

}  // namespace earpoint
