#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>

#include <earpoint/pose.h>
#include <earpoint/serve/listen_method.h>
#include <earpoint/serve/served_clip.h>
#include <earpoint/waveform.h>

namespace earpoint {

class LiveSound;

/// Where a listener is and what they want to hear.
struct ListenWish {
  Pose source_from_target;
  std::string method = "input";  ///< a name among the methods, or kTruthName
  /// As loud as the recording is at the same time, over two seconds: what remains is place and
  /// timbre.
  bool matches_level = false;
};

/// Somebody who walks through a clip: asks for its sound part by part, each from where they are
/// then.
class Listener {
 public:
  /// @param methods  must outlive it
  Listener(std::shared_ptr<const ServedClip> clip, std::span<const ListenMethod> methods);
  ~Listener();

  /// What is heard from sample `start` on, at the clip's rate. Parts that follow one another join:
  /// the head moves evenly from the pose of the part before to this one, and methods fade into each
  /// other. A leap takes some of the sound before to warm up.
  /// @param samples  1 to the clip's rate; beyond the clip there is silence
  /// @throws InputError if the pose is not finite or absurdly far, no method has that name, or the
  ///         method lacks what it needs
  [[nodiscard]] Waveform listen(std::ptrdiff_t start, std::ptrdiff_t samples,
                                const ListenWish& wish);

  [[nodiscard]] const ServedClip& clip() const { return *clip_; }

 private:
  LiveSound& sound_of(const std::string& method);
  void match_level(Waveform& sound, std::ptrdiff_t start, bool matches);

  std::shared_ptr<const ServedClip> clip_;
  std::span<const ListenMethod> methods_;
  std::map<std::string, std::unique_ptr<LiveSound>> sounds_;  ///< of the methods listened to so far
  std::ptrdiff_t next_ = -1;  ///< the sample that a part must begin with to join the last one
  std::string method_;
  double power_recorded_ = 0.0;  ///< over the last seconds
  double power_heard_ = 0.0;
  float gain_ = 1.0F;
};

}  // namespace earpoint
