#include <earpoint/dataset/reverberant_speech.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/energy.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::size_t kSecond = 16000;
constexpr double kShortestS = 0.1;
constexpr double kLongestS = 1.3;
/// A decay is changed by at most this factor: beyond it early reflections and decay no longer
/// match.
constexpr double kMostChange = 2.5;

struct EarResponse {
  std::vector<float> samples;
  double t60_s = 0.0;
};

double rms(std::span<const float> samples) {
  return std::sqrt(energy(samples) / static_cast<double>(samples.size()));
}

/// Adds steady noise, 20 to 60 dB below the sound.
void add_noise(std::vector<float>& sound, RandomStream& random) {
  const double level = rms(sound) * std::pow(10.0, -random.uniform(20.0, 60.0) / 20.0);
  for (float& x : sound) x += static_cast<float>(level * random.normal());
}

/// All responses of a split, in the order of its clips.
std::vector<std::string> response_names(const SoundSpacesDataset& dataset) {
  std::vector<std::string> names;
  for (const SoundSpacesClip& clip : dataset.clips()) {
    for (const SoundSpacesViewpoint& viewpoint : clip.viewpoints) {
      for (const auto& [speaker, name] : viewpoint.rir) names.push_back(name);
    }
  }
  return names;
}

std::vector<std::vector<float>> read_voices(const SoundSpacesDataset& dataset) {
  std::set<std::string> names;
  for (const SoundSpacesClip& clip : dataset.clips()) {
    for (const SoundSpacesSpeaker& speaker : clip.speakers) {
      if (speaker.speech) names.insert(*speaker.speech);
    }
  }
  std::vector<std::vector<float>> voices;
  for (const std::string& name : names) {
    const Waveform speech = dataset.read_speech(name);
    const auto samples = speech.channel(0);
    if (samples.size() > 1) voices.emplace_back(samples.begin(), samples.end());
  }
  return voices;
}

}  // namespace

struct ReverberantSpeech::State {
  /// A second from anywhere in the recording, with the reverberation of the speech before it.
  [[nodiscard]] std::vector<float> second_of(std::span<const float> response,
                                             RandomStream& random) const {
    const std::vector<float>& voice = voices[random.index(voices.size())];
    const std::size_t last = voice.size() > kSecond ? voice.size() - kSecond : 0;
    const std::size_t start = last > 0 ? random.index(last + 1) : 0;
    const std::size_t lead = std::min(start, response.size() - 1);
    const std::size_t heard = std::min(voice.size() - start, kSecond);
    const std::vector<float> wet =
        convolve(std::span(voice).subspan(start - lead, lead + heard), response);
    std::vector<float> second(kSecond);
    const std::size_t kept = std::min(wet.size() - lead, kSecond);
    std::copy_n(wet.begin() + static_cast<std::ptrdiff_t>(lead), kept, second.begin());
    return second;
  }

  [[nodiscard]] EarResponse varied(RandomStream& random) const {
    const double kind = random.uniform();
    const EarResponse& drawn = ears[random.index(ears.size())];
    if (kind < 0.25) return drawn;
    EarResponse changed;
    double wanted_s = random.uniform(kShortestS, kLongestS);
    if (kind < 0.75) {
      wanted_s = std::clamp(wanted_s, drawn.t60_s / kMostChange, drawn.t60_s * kMostChange);
      changed = drawn;
      change_decay(changed.samples, drawn.t60_s, wanted_s);
    } else {
      changed.samples = noise_response(wanted_s, std::ssize(drawn.samples), random);
    }
    const std::optional<double> t60_s = middle_t60_s(changed.samples);
    if (!t60_s || *t60_s > 2.0 * kLongestS) return drawn;  // cut off before it has decayed
    changed.t60_s = *t60_s;
    return changed;
  }

  std::vector<std::vector<float>> voices;
  std::vector<EarResponse> ears;
};

ReverberantSpeech::ReverberantSpeech(const SoundSpacesDataset& dataset,
                                     std::size_t most_responses) {
  EARPOINT_CHECK(most_responses > 0);
  auto state = std::make_unique<State>();
  state->voices = read_voices(dataset);
  const std::vector<std::string> names = response_names(dataset);
  const std::size_t kept = std::min(names.size(), most_responses);
  for (std::size_t i = 0; i < kept; ++i) {
    const std::string& name = names[i * names.size() / kept];
    const Waveform response = dataset.read_response(name).sound;
    for (int ear = 0; ear < response.channels(); ++ear) {
      const auto samples = response.channel(ear);
      if (const auto t60_s = middle_t60_s(samples)) {
        state->ears.push_back({{samples.begin(), samples.end()}, *t60_s});
      }
    }
  }
  if (state->voices.empty() || state->ears.empty()) {
    throw InputError(dataset.path_of(".").string(),
                     fmt::format("has {} recordings of speech and {} responses that decay by 35 dB",
                                 state->voices.size(), state->ears.size()),
                     "simulate longer responses");
  }
  state_ = std::move(state);
}

ReverberantSpeech::~ReverberantSpeech() = default;
ReverberantSpeech::ReverberantSpeech(ReverberantSpeech&&) noexcept = default;
ReverberantSpeech& ReverberantSpeech::operator=(ReverberantSpeech&&) noexcept = default;

std::size_t ReverberantSpeech::responses() const { return state_->ears.size(); }

ReverberantSecond ReverberantSpeech::draw(RandomStream& random) const {
  const EarResponse response = state_->varied(random);
  ReverberantSecond second{state_->second_of(response.samples, random), response.t60_s};
  if (random.uniform() < 0.5) add_noise(second.sound, random);
  return second;
}

ReverberantSecond ReverberantSpeech::measured(std::size_t response, RandomStream& random) const {
  EARPOINT_CHECK(response < responses());
  const EarResponse& ear = state_->ears[response];
  return {state_->second_of(ear.samples, random), ear.t60_s};
}

}  // namespace earpoint
