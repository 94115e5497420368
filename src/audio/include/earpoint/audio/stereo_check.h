#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The kind of a two-channel recording, by delay, level and coherence between the channels.
enum class StereoKind {
  plausible,    ///< nothing speaks against two ears
  one_channel,  ///< one of them is silent or nearly so
  same,    ///< both hold the same sound: mono, or a dry source exactly in a symmetric head's middle
  panned,  ///< the level differs alike at all frequencies, without a delay
  inverted,  ///< one has the opposite sign
};

/// "dual_mono", "panned" ...; for programs.
[[nodiscard]] std::string_view name_of(StereoKind kind);

/// Distinguishes binaural recordings from other stereo.
///
/// By half seconds: at an ear away from the source sound is both later, by up to 0.9 ms, and
/// weaker, the more the higher the frequency. A mixing desk changes the level alone and all
/// frequencies alike; a swapped lead turns the sign, which no delay does at low frequencies. Speech
/// of a few seconds or any sound between 100 Hz and 1.5 kHz is enough. Spaced microphones are not
/// told from ears. Memory: 100 bytes for each half second.
class StereoCheck {
 public:
  /// @param sample_rate_hz  >= 8000
  explicit StereoCheck(int sample_rate_hz);

  /// The next samples. @param block  shape [2][any], finite
  void add(const Waveform& block);

  /// What the sound so far is; the rest of a half second does not count, unless there is nothing
  /// else.
  [[nodiscard]] StereoKind kind();

  /// The kind of half a second.
  struct Finding {
    double power = 0.0;       ///< of both channels
    double left_share = 0.0;  ///< of the power, 0 to 1
    double residual =
        1.0;  ///< of a channel that is no scaled copy of the other, share of its power
    double copy_gain = 0.0;           ///< of that copy, right over left; negative: inverted
    double level_db = 0.0;            ///< left over right, median over 100 Hz to 1.5 kHz
    double delay_s = 0.0;             ///< of the right channel, by phase
    double agreement = 0.0;           ///< of the phases with a delay of at most 0.9 ms, -1 to 1
    double inverted_agreement = 0.0;  ///< the same with one sign turned
  };
  [[nodiscard]] const std::vector<Finding>& findings() const { return findings_; }

 private:
  void add_frame();
  void end_block();

  int rate_hz_;
  int frame_;
  RealFft<float> fft_;
  std::vector<float> window_;
  std::array<std::vector<float>, 2> samples_;  ///< not yet in a frame
  std::array<std::vector<std::complex<float>>, 2> spectra_;
  std::array<std::vector<double>, 2> power_;  ///< by bin, of this block
  std::vector<std::complex<double>> cross_;
  int frames_ = 0;  ///< of this block
  std::vector<Finding> findings_;
};

}  // namespace earpoint
