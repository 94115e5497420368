#include <earpoint/locate/active_speaker.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kOutsidePrior = 0.1;
// Probability that a turn goes on for another 0.2 s: turns of 4 s on average.
constexpr double kGoesOn = 0.95;
// However clear the direction is, the sound may be something else (a reflection, a second voice).
constexpr double kLeastLikelihood = 1e-4;
// Standard deviation of a box's direction: 2 degrees plus 0.15 of its angular width.
constexpr double kLeastSpread_rad = radians_from_degrees(2.0);
constexpr double kSpreadByWidth = 0.15;
// Sound counts as speech from 25 dB below the loud moments up, with a transition of a few decibels.
constexpr double kVoiceRange_db = 25.0;
constexpr double kVoiceSlope_db = 2.5;
constexpr double kLoudShare = 0.95;
constexpr double kSilence_db = -100.0;

/// States of a moment: everybody in the picture and, last, somebody outside.
std::vector<double> priors(const SpeakerMoment& moment) {
  const std::size_t people = moment.tracks.size();
  if (people == 0) return {1.0};
  std::vector<double> prior(people + 1, (1.0 - kOutsidePrior) / static_cast<double>(people));
  prior.back() = kOutsidePrior;
  return prior;
}

std::vector<double> emissions(const SpeakerMoment& moment) {
  EARPOINT_CHECK(moment.likelihoods.size() == moment.tracks.size());
  std::vector<double> emission = moment.likelihoods;
  emission.push_back(moment.outside);
  const double largest = *std::ranges::max_element(emission);
  for (double& value : emission) {
    value = largest > 0.0 ? std::max(value / largest, kLeastLikelihood) : 1.0;
  }
  return emission;
}

/// For every state of a moment, the state of the next moment that is the same person.
std::vector<std::size_t> successors(const SpeakerMoment& from, const SpeakerMoment& to) {
  std::vector<std::size_t> next;
  for (const int track : from.tracks) {
    const auto found = std::ranges::find(to.tracks, track);
    next.push_back(static_cast<std::size_t>(found - to.tracks.begin()));  // if not found: outside
  }
  next.push_back(to.tracks.size());
  return next;
}

void normalise(std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  for (double& value : values) value /= sum;
}

double level_db(double power) { return 10.0 * std::log10(power + 1e-30); }

/// The level that one moment in twenty exceeds.
double loud_db(std::span<const SpeakerMoment> moments) {
  std::vector<double> levels;
  for (const SpeakerMoment& moment : moments) levels.push_back(level_db(moment.power));
  const auto at = levels.begin() +
                  static_cast<std::ptrdiff_t>(kLoudShare * static_cast<double>(levels.size() - 1));
  std::ranges::nth_element(levels, at);
  return *at;
}

}  // namespace

BoxDirection direction_of_box(const Box& box, double horizontal_fov_rad) {
  EARPOINT_CHECK(horizontal_fov_rad > 0.0 && horizontal_fov_rad < kPi);
  const double half_width = std::tan(0.5 * horizontal_fov_rad);
  const auto azimuth_of = [&](double x) { return std::atan((1.0 - 2.0 * x) * half_width); };
  const double left_rad = azimuth_of(box.x_min);
  const double right_rad = azimuth_of(box.x_max);
  return {.azimuth_rad = 0.5 * (left_rad + right_rad),
          .spread_rad = kLeastSpread_rad + kSpreadByWidth * (left_rad - right_rad)};
}

SpeakerMoment speaker_moment(std::span<const TrackedPerson> people,
                             const DirectionEvidence& evidence, double horizontal_fov_rad) {
  SpeakerMoment moment;
  for (const TrackedPerson& person : people) {
    const BoxDirection direction = direction_of_box(person.box, horizontal_fov_rad);
    moment.tracks.push_back(person.track);
    moment.likelihoods.push_back(
        evidence.likelihood_near(direction.azimuth_rad, direction.spread_rad));
  }
  moment.outside = evidence.likelihood_outside(0.5 * horizontal_fov_rad);
  moment.power = evidence.power;
  return moment;
}

std::vector<SpeakerBelief> active_speakers(std::span<const SpeakerMoment> moments) {
  std::vector<SpeakerBelief> beliefs;
  if (moments.empty()) return beliefs;
  const std::size_t count = moments.size();
  // Forward: what the moments up to each one say.
  std::vector<std::vector<double>> forward(count);
  for (std::size_t t = 0; t < count; ++t) {
    const std::vector<double> prior = priors(moments[t]);
    const std::vector<double> emission = emissions(moments[t]);
    std::vector<double> state = prior;
    if (t > 0) {
      for (double& value : state) value *= 1.0 - kGoesOn;
      const auto next = successors(moments[t - 1], moments[t]);
      for (std::size_t i = 0; i < next.size(); ++i) state[next[i]] += kGoesOn * forward[t - 1][i];
    }
    for (std::size_t i = 0; i < state.size(); ++i) state[i] *= emission[i];
    normalise(state);
    forward[t] = std::move(state);
  }
  // Backward: what those after it say.
  beliefs.resize(count);
  std::vector<double> backward(moments.back().tracks.size() + 1, 1.0);
  const double loud = std::max(loud_db(moments), kSilence_db);
  for (std::size_t t = count; t-- > 0;) {
    std::vector<double> state = forward[t];
    for (std::size_t i = 0; i < state.size(); ++i) state[i] *= backward[i];
    normalise(state);
    SpeakerBelief& belief = beliefs[t];
    belief.outside = state.back();
    state.pop_back();
    belief.people = std::move(state);
    const double below_db = loud - kVoiceRange_db - level_db(moments[t].power);
    belief.voice = 1.0 / (1.0 + std::exp(below_db / kVoiceSlope_db));
    if (t == 0) break;
    const std::vector<double> prior = priors(moments[t]);
    const std::vector<double> emission = emissions(moments[t]);
    double anew = 0.0;
    for (std::size_t i = 0; i < prior.size(); ++i) anew += prior[i] * emission[i] * backward[i];
    const auto next = successors(moments[t - 1], moments[t]);
    std::vector<double> earlier(next.size());
    for (std::size_t i = 0; i < next.size(); ++i) {
      earlier[i] = kGoesOn * emission[next[i]] * backward[next[i]] + (1.0 - kGoesOn) * anew;
    }
    normalise(earlier);
    backward = std::move(earlier);
  }
  return beliefs;
}

}  // namespace earpoint
