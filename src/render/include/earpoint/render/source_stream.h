#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/audio/ambient_separation.h>
#include <earpoint/audio/butterworth.h>
#include <earpoint/audio/resample.h>
#include <earpoint/audio/stereo_check.h>
#include <earpoint/plot/plot.h>
#include <earpoint/render/stream_buffer.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// What a first reading of the whole recording finds.
struct SoundSurvey {
  int sample_rate_hz = 0;
  std::ptrdiff_t samples = 0;
  std::array<double, 2> level_db{};  ///< root mean square per ear re full scale
  /// What the two channels are; where both were asked to be one channel, plausible.
  StereoKind stereo = StereoKind::plausible;
  /// What the user should know, each one line without the file's name: of stereo that is not
  /// binaural, and AudioReader::warnings().
  std::vector<std::string> warnings;

  [[nodiscard]] double duration_s() const { return static_cast<double>(samples) / sample_rate_hz; }
};

/// How a recording is separated into primary and ambient sound.
struct AmbientOptions {
  AmbientSeparation separation = AmbientSeparation::bandpass;
  /// What lies below is ambient, Hz; 0: none, and with bandpass all is primary.
  double cutoff_hz = 0.0;
};

/// Gives the next samples of a recording, at most as many as asked for: 2 ears; none after the end.
using BlockReader = std::function<Waveform(std::ptrdiff_t)>;

/// Reads a recording once from end to end.
/// @param where  what errors call it, e.g. its file
/// @return the survey; its warnings are left to warning_of()
/// @throws InputError if it is shorter than 0.1 s, is sampled below 16 kHz, is silent throughout
///         (below -100 dB), or holds a sample that is no number (naming its time)
[[nodiscard]] SoundSurvey survey_blocks(const BlockReader& read, int sample_rate_hz,
                                        const std::string& where);

/// What to say of stereo that no two ears heard; empty if nothing.
[[nodiscard]] std::string warning_of(StereoKind kind);

/// The sound from its beginning. @param sound  must outlive the reader
[[nodiscard]] BlockReader read_blocks(const Waveform& sound);

/// The recording as windows at a synthesizer's rate, read once, front to back, with bounded memory.
class SourceStream {
 public:
  /// @param model_rate_hz  at most the recording's rate
  SourceStream(BlockReader read, const SoundSurvey& survey, int model_rate_hz,
               const AmbientOptions& ambient);

  struct Window {
    Waveform primary;  ///< 2 ears, [context + samples + context]
    Waveform ambient;  ///< 2 ears, [samples]; what the primary sound leaves of the recording
  };
  /// Windows must be asked for in ascending order. Beyond the recording there is silence.
  [[nodiscard]] Window window(std::ptrdiff_t start, std::ptrdiff_t samples, std::ptrdiff_t context);

  /// What the model's rate cannot carry, at the recording's rate: 2 ears, [count] from `start`.
  /// Zeros if the rates are equal.
  [[nodiscard]] Waveform high_band(std::ptrdiff_t start, std::ptrdiff_t count);
  /// Forgets the high band before that sample.
  void drop_high_band_before(std::ptrdiff_t start) { high_.drop_before(start); }

  /// The recording drawn small, as far as it has been read.
  [[nodiscard]] const WaveformOutline& outline() const { return outline_; }

  /// The recording's length at the model's rate.
  [[nodiscard]] std::ptrdiff_t model_samples() const { return model_samples_; }

 private:
  void read_block();
  void append(const Waveform& block);
  void separate_by_band(Window& window, std::ptrdiff_t start, std::ptrdiff_t context) const;
  void separate_by_noise(Window& window, std::ptrdiff_t start, std::ptrdiff_t context) const;

  SoundSurvey survey_;
  BlockReader read_;
  std::unique_ptr<StreamResampler> down_;  // null if the rates are equal
  std::unique_ptr<StreamResampler> up_;
  std::vector<SecondOrderSection> primary_band_;
  std::ptrdiff_t model_samples_;
  std::ptrdiff_t filter_margin_ = 0;
  std::optional<NoiseSuppressor> suppressor_;
  StreamBuffer model_;    // the recording at the model's rate
  StreamBuffer primary_;  // what suppressor_ has given of it
  StreamBuffer native_;   // the recording, until its low band has come back from down_ and up_
  StreamBuffer high_;     // native minus low band
  WaveformOutline outline_;
  bool ended_ = false;
};

}  // namespace earpoint
