#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/dataset/soundspaces.h>

namespace earpoint {

/// T60 of a response as an estimator of reverberation time is taught it: T30 of the octaves around
/// 500 and 1000 Hz together (353.6 to 1414.2 Hz), where speech is strong.
/// @param response  one ear, shape [samples], 16 kHz
/// @return  seconds; nothing if the decay does not reach -35 dB before the response ends
[[nodiscard]] std::optional<double> middle_t60_s(std::span<const float> response);

/// Exponentially decaying noise behind a direct sound: a response without a room.
/// Every octave decays at a pace of its own, near `t60_s`; reflections begin sparse; and the direct
/// sound is between 10 dB weaker and 8 dB stronger than all the rest.
/// @return  one ear, [samples], 16 kHz
[[nodiscard]] std::vector<float> noise_response(double t60_s, std::ptrdiff_t samples,
                                                RandomStream& random);

/// The same response with another decay: what comes `t` after its largest sample is scaled by
/// exp(-3 ln 10 t (1 / to_s - 1 / from_s)).
void change_decay(std::span<float> response, double from_s, double to_s);

/// One second of speech in a room, at 16 kHz, and how long it reverberates.
struct ReverberantSecond {
  std::vector<float> sound;  ///< [16000], of any level
  double t60_s = 0.0;        ///< middle_t60_s() of the response that was convolved with
};

/// Speech with known reverberation, out of a data set's voices and responses. For learning, the
/// responses are varied so that 0.1 to 1.3 s come up about equally often; for measuring, they are
/// taken as they are.
/// Const calls may be made from many threads.
class ReverberantSpeech {
 public:
  /// Reads a split's speech, and as many of its responses as may be kept, evenly over the clips.
  /// @param most_responses  > 0; a response has two ears
  /// @throws InputError naming the file that is missing or malformed, or the data set if its
  ///         responses' decays cannot be measured
  explicit ReverberantSpeech(const SoundSpacesDataset& dataset, std::size_t most_responses = 1500);
  ~ReverberantSpeech();
  ReverberantSpeech(ReverberantSpeech&&) noexcept;
  ReverberantSpeech& operator=(ReverberantSpeech&&) noexcept;

  /// How many ears' responses it holds whose decay could be measured.
  [[nodiscard]] std::size_t responses() const;

  /// For learning: half of the responses with another decay, a quarter as they are, a quarter from
  /// noise_response(); half of the sounds with steady noise, 20 to 60 dB weaker.
  [[nodiscard]] ReverberantSecond draw(RandomStream& random) const;

  /// For measuring: that response as it is, with a drawn second of a drawn voice.
  /// @param response  less than responses()
  [[nodiscard]] ReverberantSecond measured(std::size_t response, RandomStream& random) const;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

}  // namespace earpoint
