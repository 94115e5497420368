#pragma once

#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/generate/speech_corpus.h>
#include <earpoint/record/session_truth.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Somebody says something.
struct Utterance {
  int person = 0;
  double begin_s = 0.0;  ///< session time
  Waveform speech;       ///< dry, one channel, as read_speech gives it
};

/// Draws who speaks when: in turns with short pauses, now and then into each other's end, now and
/// then all the while. Nobody speaks twice at once. A voice's recordings are used up before one
/// comes again.
/// @param voices   one per person
/// @param begin_s  nobody speaks before
/// @param end_s    nor after
/// @return ascending by begin
/// @throws InputError as read_speech
std::vector<Utterance> draw_turns(const std::vector<const SpeechSpeaker*>& voices, double begin_s,
                                  double end_s, RandomStream& random);

/// When it is loud enough to be speech: 20 ms frames within 35 dB of the loudest, over pauses of up
/// to 0.3 s, in session time.
std::vector<SpeechInterval> speech_intervals(const Utterance& utterance);

}  // namespace earpoint
