#pragma once

#include <vector>

#include <earpoint/record_simulation/person_path.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// A piece of somebody's speech during which the way to a listener changes, or does not.
struct TurnPiece {
  double begin_s = 0.0;  ///< of its first sample
  bool moves = false;
  std::vector<float> speech;
};

/// Cuts speech where motion begins and ends, 0.2 s before and behind it, and fades the pieces into
/// each other there: their sum is the speech.
/// @param speech  one channel
/// @param moves   in any order, may overlap
/// @return ascending, at least one
std::vector<TurnPiece> cut_turn(const Waveform& speech, double begin_s, std::vector<Span> moves);

}  // namespace earpoint
