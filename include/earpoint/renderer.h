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

/// Options of a model.
struct RendererOptions {
  /// Field of view of the source's camera.
  double horizontal_fov_rad = radians_from_degrees(90.0);
  /// For gtf networks trained for both textures: 1 natural, with the modulation and decay of such a
  /// room; 0 the mean, with the least error of magnitudes. Nothing: natural; for any network.
  std::optional<double> texture{};
  /// Head filters of `dsp`, a SOFA file. Nothing: the KEMAR set of libmysofa.
  std::optional<std::filesystem::path> hrtf{};
  int threads = 1;  ///< > 0; the samples are the same for any number
};

/// A point on the path of a moving earpoint.
struct PathPoint {
  double time_s = 0.0;        ///< since the sound's beginning
  Pose source_from_target{};  ///< the earpoint's head in the source's frame
};

/// What is known of a recorded moment, and the earpoint.
struct RenderRequest {
  const Image* picture = nullptr;  ///< of the source's camera, RGB; null: no picture
  /// Box of the speaker in the picture, and position of their mouth, metres in the source's frame.
  /// Neither: the network locates the speaker by picture and sound, if it can.
  std::optional<Box> speaker_box{};
  std::optional<Vector3> speaker_m{};  ///< see speaker_box
  /// The earpoint: pose of its head in the source's frame.
  Pose target{};
  /// Instead of `target`, for a moving earpoint: ascending times, from 0 to the sound's end.
  std::vector<PathPoint> path{};
  /// Sound above the model's band follows the gain of its top octave.
  bool extend_band = true;
  bool limit = true;     ///< keep the output within full scale
  double gain_db = 0.0;  ///< of the output, before the limiter; -100 to 100
};

/// Renders a recorded moment at another position: the samples of `earpoint render` for the same
/// binaural sound, picture and speaker.
///
/// One caller at a time; renderers share nothing.
class EARPOINT_API Renderer {
 public:
  /// @param model  the name of an installed model (installed_networks()), a weight file, `dsp` for
  ///               signal processing by head filters, or `input` for the unchanged sound
  /// @throws InputError if there is no such model, it makes no sound, or it has no such texture
  [[nodiscard]] static Renderer open(const std::string& model = "gtf",
                                     const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// Renders a whole clip. Ambient sound below the model's cutoff is added unchanged.
  /// @param sound  two ears, left first, or one channel, whose voice is placed at the speaker by
  ///               head filters if their position is known; at least 0.1 s, 16 kHz or more
  /// @return two ears, as long as the sound and at its rate
  /// @throws InputError if the sound is too short, of a lower rate, silent, or has NaN; if the
  ///         model needs a picture or a speaker and none is given; if the path does not cover the
  ///         sound; if a place, turn or gain is not finite, or beyond 10 km or 100 dB
  /// @throws std::logic_error if the sound has neither one nor two channels
  [[nodiscard]] Waveform render(const Waveform& sound, const RenderRequest& request);

  /// What is outside the model's training data: messages, a line each.
  /// @param sound, request  as render() takes them
  /// @throws InputError for a sound, box or path that render() refuses
  [[nodiscard]] std::vector<std::string> warnings(const Waveform& sound,
                                                  const RenderRequest& request) const;

  /// Starts rendering live sound. The stream may outlive the renderer.
  /// @throws InputError if the sample rate or the phase rounds are not supported, or the model
  ///         is neither a gtf network nor `dsp`
  [[nodiscard]] Stream stream(const StreamOptions& options = {}) const;

  /// The weight file in use, or `dsp` or `input`.
  [[nodiscard]] const std::string& model() const;

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
