#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/error.h>
#include <earpoint/export.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/stream.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// How a model is opened.
struct RendererOptions {
  /// Of the source's camera.
  double horizontal_fov_rad = radians_from_degrees(90.0);
  /// Of a gtf network that was trained for both: 1 natural, with the modulation and decay of such a
  /// room; 0 the mean, with the least error of magnitudes. Nothing: natural, and any network.
  std::optional<double> texture{};
  /// Head filters of `dsp`, a SOFA file. Nothing: the KEMAR set of libmysofa.
  std::optional<std::filesystem::path> hrtf{};
  int threads = 1;  ///< > 0; the samples are the same for any number
};

/// A place of a moving earpoint.
struct PathPoint {
  double time_s = 0.0;        ///< since the sound's beginning
  Pose source_from_target{};  ///< the earpoint's head in the source's frame
};

/// What is known of a recorded moment, and where it is heard.
struct RenderRequest {
  const Image* picture = nullptr;  ///< what the source's camera sees, RGB; null: no picture
  /// Where the speaker is seen in it, and where their mouth is, metres in the source's frame.
  /// Neither: the network finds them by picture and sound, if it can.
  std::optional<Box> speaker_box{};
  std::optional<Vector3> speaker_m{};  ///< see speaker_box
  /// Where the earpoint is: its head in the source's frame.
  Pose target{};
  /// In place of `target`, where it moves: times grow, from 0 to the sound's end.
  std::vector<PathPoint> path{};
  /// Carry what lies above the model's band along at the gain of its top octave.
  bool extend_band = true;
  bool limit = true;     ///< keep the output within full scale
  double gain_db = 0.0;  ///< of the output, before it is limited
};

/// Hears a recorded moment from another place. The same samples as `earpoint render` writes.
///
/// One caller at a time; renderers share nothing.
class EARPOINT_API Renderer {
 public:
  /// @param model  the name of an installed model (installed_networks()), a weight file, `dsp` for
  ///               signal processing by head filters, or `input` for the sound as it is
  /// @throws InputError if there is no such model, it makes no sound, or it has no such texture
  [[nodiscard]] static Renderer open(const std::string& model = "gtf",
                                     const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// Renders a whole clip. Ambient sound below the model's cutoff passes by and is added.
  /// @param sound  two ears, left first, or one channel, whose voice is put at the speaker by head
  ///               filters if it is known where they are; at least 0.1 s, 16 kHz or more
  /// @return two ears, as long as the sound and at its rate
  /// @throws InputError if the sound is too short, of a lower rate, silent, or has NaN; if the
  /// model
  ///         needs a picture or a speaker and none is given; if the path does not cover the sound
  /// @throws std::logic_error if the sound has neither one nor two channels
  [[nodiscard]] Waveform render(const Waveform& sound, const RenderRequest& request);

  /// What of that lies outside of what the model was trained for: a line each, for people.
  [[nodiscard]] std::vector<std::string> warnings(const Waveform& sound,
                                                  const RenderRequest& request) const;

  /// Starts to render live sound. The stream may outlive the renderer.
  /// @throws InputError if the sampling rate is none of those, or the model is not a gtf network
  [[nodiscard]] Stream stream(const StreamOptions& options = {}) const;

  /// The weight file that is rendered with, or `dsp` or `input`.
  [[nodiscard]] const std::string& model() const;

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
