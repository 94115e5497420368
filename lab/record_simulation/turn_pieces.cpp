#include "turn_pieces.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kMargin_s = 0.2;
constexpr double kFade_s = 0.1;
// Shorter still stretches get no trace of their own.
constexpr double kShortestStill_s = 0.5;

std::vector<Span> widened(std::vector<Span> moves, const Span& within) {
  std::ranges::sort(moves, {}, &Span::begin_s);
  std::vector<Span> spans;
  for (const Span& move : moves) {
    Span span{move.begin_s - kMargin_s, move.end_s + kMargin_s};
    if (span.end_s <= within.begin_s || span.begin_s >= within.end_s) continue;
    if (span.begin_s - within.begin_s < kShortestStill_s) span.begin_s = within.begin_s;
    if (within.end_s - span.end_s < kShortestStill_s) span.end_s = within.end_s;
    if (!spans.empty() && span.begin_s - spans.back().end_s < kShortestStill_s) {
      spans.back().end_s = std::max(spans.back().end_s, span.end_s);
    } else {
      spans.push_back(span);
    }
  }
  return spans;
}

/// The speech between two cuts, with a cross-fade around each.
TurnPiece piece_of(const Waveform& speech, double begin_s, std::optional<double> from_s,
                   std::optional<double> to_s, bool moves) {
  const double rate_hz = speech.sample_rate_hz();
  const auto sample_at = [&](double time_s) {
    const auto sample = static_cast<std::ptrdiff_t>(std::floor((time_s - begin_s) * rate_hz));
    return std::clamp<std::ptrdiff_t>(sample, 0, speech.samples());
  };
  const std::ptrdiff_t first = from_s ? sample_at(*from_s - kFade_s / 2) : 0;
  const std::ptrdiff_t last = to_s ? sample_at(*to_s + kFade_s / 2) : speech.samples();
  // From 0 to 1 around a cut.
  const auto rise = [&](double time_s, double cut_s) {
    const double u = std::clamp((time_s - cut_s) / kFade_s + 0.5, 0.0, 1.0);
    return 0.5 - 0.5 * std::cos(kPi * u);
  };
  TurnPiece piece{
      .begin_s = begin_s + static_cast<double>(first) / rate_hz, .moves = moves, .speech = {}};
  for (std::ptrdiff_t i = first; i < last; ++i) {
    const double time_s = begin_s + static_cast<double>(i) / rate_hz;
    double weight = 1.0;
    if (from_s) weight *= rise(time_s, *from_s);
    if (to_s) weight *= 1.0 - rise(time_s, *to_s);
    piece.speech.push_back(static_cast<float>(weight) * speech.channel(0)[i]);
  }
  return piece;
}

}  // namespace

std::vector<TurnPiece> cut_turn(const Waveform& speech, double begin_s, std::vector<Span> moves) {
  EARPOINT_CHECK(speech.channels() == 1 && speech.samples() > 0);
  const Span whole{begin_s, begin_s + speech.duration_s()};
  std::vector<TurnPiece> pieces;
  std::optional<double> cut_s;
  for (const Span& span : widened(std::move(moves), whole)) {
    if (span.begin_s > whole.begin_s) {
      pieces.push_back(piece_of(speech, begin_s, cut_s, span.begin_s, false));
      cut_s = span.begin_s;
    }
    std::optional<double> end_s;
    if (span.end_s < whole.end_s) end_s = span.end_s;
    pieces.push_back(piece_of(speech, begin_s, cut_s, end_s, true));
    cut_s = end_s;
    if (!end_s) return pieces;
  }
  pieces.push_back(piece_of(speech, begin_s, cut_s, std::nullopt, false));
  return pieces;
}

}  // namespace earpoint
