#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/pose.h>

#include "model_search.h"
#include "parameters.h"

namespace earpoint::plugin {

/// What the host's parameters say at one moment.
struct Settings {
  Pose earpoint{};                     ///< of its head, in the source's frame; within 10 km
  std::optional<Vector3> speaker_m{};  ///< the mouth, the same; nothing: located from the sound
  int model = 0;                       ///< index into the models; one that is not there: the first
  bool natural_texture = true;         ///< for networks trained for both textures
  bool bypass = false;                 ///< the input, as late as the output would be
};

/// Live sound of several networks, between which one may switch without a click.
///
/// Every network has a stream that is made beforehand. A switch feeds the new one for a second,
/// which is what a network hears at a time, then cross-fades to it; a thread of this object's own
/// resets the old one. The latency is that of the slowest network for all, so that sounds that are
/// cross-faded belong to the same moment.
///
/// process() allocates nothing and takes no lock; one caller at a time.
class LiveRenderer {
 public:
  /// Reads the models and makes their streams. Never throws for a bad rate or model: see problem().
  /// @param sample_rate_hz  as the host gives it
  LiveRenderer(const std::vector<StreamingModel>& models, double sample_rate_hz);
  ~LiveRenderer();
  LiveRenderer(const LiveRenderer&) = delete;
  LiveRenderer& operator=(const LiveRenderer&) = delete;

  /// Why the sound passes unchanged, one line; empty if it does not.
  [[nodiscard]] const std::string& problem() const;
  /// The same for the host.
  [[nodiscard]] Status status() const;
  /// Models that could not be read, for which the first that could plays: a line each.
  [[nodiscard]] const std::vector<std::string>& left_out() const;

  /// Restarts from silence; the first block then chooses its model at once. Not for the audio
  /// thread, and not while process() runs.
  void reset();

  /// Renders the next samples.
  /// @param in      left and right ear of the source, [2][frames]
  /// @param out     left and right ear of the earpoint, latency_samples() late; may be the memory
  ///                of `in`
  /// @param frames  >= 0, may change with every call
  void process(const Settings& settings, const float* const* in, float* const* out,
               std::ptrdiff_t frames);

  /// Whether process() with these settings would play their model or begin to switch to it; not
  /// while a stream that has played is being reset.
  [[nodiscard]] bool is_ready_for(const Settings& settings) const;

  /// The same for every model; 0 if there is a problem.
  [[nodiscard]] std::ptrdiff_t latency_samples() const;

  /// Where the network that plays takes the speaker's mouth to be; nothing before the first sound.
  [[nodiscard]] std::optional<Vector3> speaker_m() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint::plugin
