#include <earpoint/record_simulation/spoken_turns.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <earpoint/error.h>

namespace earpoint {
namespace {

// Pauses between turns: close to real conversations (Heldner and Edlund, J. Phonetics 38, 2010),
// with a median of about 0.1 s and overlaps in 40 %.
constexpr double kPause_s = 0.15;
constexpr double kPauseSpread_s = 0.45;
constexpr double kLongestOverlap_s = 1.2;
constexpr double kLongestPause_s = 1.5;
constexpr double kGoesOnShare = 0.1;      // of the turns: the same person goes on
constexpr double kInterruptShare = 0.12;  // of the turns: somebody talks over it
constexpr double kLongest_s = 7.0;
constexpr double kShortest_s = 1.5;
constexpr double kSpeechRate_hz = 16000.0;

/// The recordings of one voice, in a shuffled order that repeats only when all were heard.
class VoiceDeck {
 public:
  explicit VoiceDeck(const SpeechSpeaker& voice) : voice_(&voice) {}

  const SpeechRecording& draw(RandomStream& random) {
    if (left_.empty()) {
      for (std::size_t i = 0; i < voice_->recordings.size(); ++i) left_.push_back(i);
    }
    const std::size_t place = random.index(left_.size());
    const std::size_t drawn = left_[place];
    left_[place] = left_.back();
    left_.pop_back();
    return voice_->recordings[drawn];
  }

 private:
  const SpeechSpeaker* voice_;
  std::vector<std::size_t> left_;
};

int draw_other(int person, int people, RandomStream& random) {
  const auto step = 1 + static_cast<int>(random.index(static_cast<std::uint64_t>(people - 1)));
  return (person + step) % people;
}

/// The first part of a long recording, faded out over 20 ms.
Waveform shortened(const Waveform& speech, double longest_s) {
  const auto longest = static_cast<std::ptrdiff_t>(longest_s * speech.sample_rate_hz());
  if (speech.samples() <= longest) return speech;
  Waveform part(1, longest, speech.sample_rate_hz());
  const std::ptrdiff_t fade = speech.sample_rate_hz() / 50;
  for (std::ptrdiff_t i = 0; i < longest; ++i) {
    const auto left = static_cast<float>(longest - i) / static_cast<float>(fade);
    part.channel(0)[i] = speech.channel(0)[i] * std::min(1.0F, left);
  }
  return part;
}

/// Writes turns one after the other.
class TurnWriter {
 public:
  TurnWriter(const std::vector<const SpeechSpeaker*>& voices, double begin_s, double end_s,
             RandomStream& random)
      : end_s_(end_s), random_(random), free_from_s_(voices.size(), begin_s) {
    for (const SpeechSpeaker* voice : voices) decks_.emplace_back(*voice);
  }

  /// @return when it ends; near the end of the session nothing is added, and the end is returned
  double speak(int person, double begin_s) {
    // On a whole sample, so that the written truth is exact.
    begin_s = std::ceil(std::max(begin_s, free_from_s_[person]) * kSpeechRate_hz) / kSpeechRate_hz;
    const double left_s = end_s_ - begin_s;
    if (left_s < kShortest_s) return end_s_;
    Waveform speech =
        shortened(read_speech(decks_[person].draw(random_).path), std::min(kLongest_s, left_s));
    free_from_s_[person] = begin_s + speech.duration_s();
    turns_.push_back({.person = person, .begin_s = begin_s, .speech = std::move(speech)});
    return free_from_s_[person];
  }

  std::vector<Utterance> take() {
    std::ranges::stable_sort(turns_, {}, &Utterance::begin_s);
    return std::move(turns_);
  }

 private:
  double end_s_;
  RandomStream& random_;
  std::vector<double> free_from_s_;
  std::vector<VoiceDeck> decks_;
  std::vector<Utterance> turns_;
};

}  // namespace

std::vector<Utterance> draw_turns(const std::vector<const SpeechSpeaker*>& voices, double begin_s,
                                  double end_s, RandomStream& random) {
  EARPOINT_CHECK(voices.size() > 1);
  const auto people = static_cast<int>(voices.size());
  TurnWriter writer(voices, begin_s, end_s, random);
  auto person = static_cast<int>(random.index(static_cast<std::uint64_t>(people)));
  for (double time_s = begin_s; time_s < end_s;) {
    const double ends_s = writer.speak(person, time_s);
    if (ends_s < end_s && random.uniform() < kInterruptShare) {
      writer.speak(draw_other(person, people, random), random.uniform(time_s, ends_s));
    }
    const double pause_s = std::clamp(kPause_s + kPauseSpread_s * random.normal(),
                                      -kLongestOverlap_s, kLongestPause_s);
    time_s = std::max(begin_s, ends_s + pause_s);
    if (ends_s >= end_s) break;
    if (random.uniform() >= kGoesOnShare) person = draw_other(person, people, random);
  }
  return writer.take();
}

std::vector<SpeechInterval> speech_intervals(const Utterance& utterance) {
  constexpr double kFrame_s = 0.02;
  constexpr double kBelowLoudest_db = 35.0;
  constexpr double kShortestPause_s = 0.3;
  const std::span<const float> samples = utterance.speech.channel(0);
  const auto frame = static_cast<std::ptrdiff_t>(kFrame_s * utterance.speech.sample_rate_hz());
  std::vector<double> powers;
  for (std::ptrdiff_t begin = 0; begin + frame <= std::ssize(samples); begin += frame) {
    double sum = 0.0;
    for (std::ptrdiff_t i = begin; i < begin + frame; ++i) {
      sum += static_cast<double>(samples[i]) * samples[i];
    }
    powers.push_back(sum);
  }
  std::vector<SpeechInterval> intervals;
  if (powers.empty()) return intervals;
  const double least =
      *std::max_element(powers.begin(), powers.end()) * std::pow(10.0, -kBelowLoudest_db / 10.0);
  for (std::size_t i = 0; i < powers.size(); ++i) {
    if (powers[i] <= 0.0 || powers[i] < least) continue;
    const double begin_s = utterance.begin_s + static_cast<double>(i) * kFrame_s;
    if (intervals.empty() || begin_s - intervals.back().end_s > kShortestPause_s) {
      intervals.push_back({begin_s, begin_s});
    }
    intervals.back().end_s = begin_s + kFrame_s;
  }
  return intervals;
}

}  // namespace earpoint
