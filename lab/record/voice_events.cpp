#include "voice_events.h"

#include "delay_finder.h"
#include "own_voice.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kLevelHop_s = 0.1;
constexpr float kNothing_db = -120.0F;
constexpr float kBelowVoice_db = 20.0F;  ///< speech counts down to this below its usual level
constexpr float kAloneBy_db = 5.0F;      ///< over every other voice, each re its own
constexpr double kSame_s = 0.4e-3;       ///< peaks this close count as one

std::vector<float> levels_of(const Waveform& sound) {
  const auto hop = static_cast<std::ptrdiff_t>(kLevelHop_s * sound.sample_rate_hz());
  std::vector<float> levels(static_cast<std::size_t>(sound.samples() / hop));
  const auto x = sound.channel(0);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    double sum = 1e-12;
    for (const float v : x.subspan(i * hop, hop)) sum += static_cast<double>(v) * v;
    levels[i] = static_cast<float>(10.0 * std::log10(sum / static_cast<double>(hop)));
  }
  return levels;
}

/// Mean level over an event; kNothing_db where it was not recorded.
float level_at(const std::vector<float>& levels, double device_s) {
  const auto first = static_cast<std::ptrdiff_t>((device_s - 0.5 * kEvent_s) / kLevelHop_s);
  const auto count = static_cast<std::ptrdiff_t>(kEvent_s / kLevelHop_s);
  if (first < 0 || first + count > std::ssize(levels)) return kNothing_db;
  double power = 0.0;
  for (std::ptrdiff_t i = first; i < first + count; ++i) power += std::pow(10.0, 0.1 * levels[i]);
  return static_cast<float>(10.0 * std::log10(power / static_cast<double>(count)));
}

/// @return an empty span where the sound does not reach that far
std::span<const float> samples_at(const Waveform& sound, int channel, std::ptrdiff_t first,
                                  std::ptrdiff_t count) {
  if (first < 0 || first + count > sound.samples()) return {};
  return sound.channel(channel).subspan(first, count);
}

/// How much later a time is than expected.
double lag_s(const HeardEvent& heard, const HeardTime& time) {
  return time.device_s - heard.expected_s;
}

/// Height of the peak on which both agree; 0 if there is none.
double agreement(const HeardEvent& heard, const HeardTime& time, const HeardEvent& other) {
  double highest = 0.0;
  for (const HeardTime& theirs : other.times) {
    if (std::abs(lag_s(other, theirs) - lag_s(heard, time)) > kSame_s) continue;
    highest = std::max(highest, theirs.height);
  }
  return highest;
}

/// Removes peaks beside a higher one. They belong to it and would otherwise get the support of its
/// neighbours.
void drop_side_peaks(std::vector<SoundEvent>& events) {
  for (SoundEvent& event : events) {
    for (HeardEvent& heard : event.heard) {
      const std::vector<HeardTime> all = heard.times;
      std::erase_if(heard.times, [&](const HeardTime& time) {
        return std::ranges::any_of(all, [&](const HeardTime& other) {
          return other.height > time.height && std::abs(other.device_s - time.device_s) < kSame_s;
        });
      });
    }
  }
}

/// Weights peaks by how often they recur in the same ear within a second or two, as voices do and
/// noise does not. The first of those that recur is taken as the direct sound.
void weigh_by_neighbours(std::vector<SoundEvent>& events) {
  constexpr double kAround_s = 1.5;
  constexpr double kStrong = 0.5;
  constexpr double kLater = 0.7;
  const std::vector<SoundEvent> plain = events;
  for (std::size_t e = 0; e < events.size(); ++e) {
    for (HeardEvent& heard : events[e].heard) {
      std::vector<double> support(heard.times.size());
      double most = 0.0;
      for (std::size_t t = 0; t < heard.times.size(); ++t) {
        for (const SoundEvent& other : plain) {
          if (other.anchor != events[e].anchor ||
              std::abs(other.anchor_s - events[e].anchor_s) > kAround_s) {
            continue;
          }
          for (const HeardEvent& theirs : other.heard) {
            if (theirs.device != heard.device || theirs.ear != heard.ear) continue;
            support[t] += agreement(heard, heard.times[t], theirs);
          }
        }
        most = std::max(most, support[t]);
      }
      double first_s = 1e9;
      for (std::size_t t = 0; t < heard.times.size(); ++t) {
        heard.times[t].height = support[t] / most;
        if (heard.times[t].height >= kStrong) {
          first_s = std::min(first_s, heard.times[t].device_s);
        }
      }
      for (HeardTime& time : heard.times) {
        time.height = time.device_s == first_s ? 1.0 : kLater * time.height;
      }
    }
  }
}

}  // namespace

VoiceEvents::VoiceEvents(const std::vector<DeviceSound>& devices, const Vector3& centre_m)
    : devices_(devices), centre_m_(centre_m), levels_db_(devices.size()) {
  const bool has_microphones =
      std::ranges::any_of(devices, [](const DeviceSound& device) { return !device.is_camera; });
  for (std::size_t d = 0; d < devices.size(); ++d) {
    if (has_microphones ? devices[d].is_camera : d != 0) continue;
    levels_db_[d] = levels_of(devices[d].sound);
  }
}

std::vector<VoiceEvents::Moment> VoiceEvents::moments(const std::vector<DeviceClock>& clocks,
                                                      double until_s) const {
  constexpr double kStep_s = 0.5 * kEvent_s;
  std::vector<std::size_t> listeners;
  for (std::size_t d = 0; d < devices_.size(); ++d) {
    if (!levels_db_[d].empty()) listeners.push_back(d);
  }
  std::vector<std::vector<float>> levels_db(listeners.size());  // by moment, while all record
  std::vector<double> times_s;
  const double end_s = std::min(until_s, devices_.front().sound.duration_s());
  for (double time_s = kStep_s; time_s < end_s; time_s += kStep_s) {
    std::vector<float> now_db;
    now_db.reserve(listeners.size());
    for (const std::size_t d : listeners) {
      now_db.push_back(level_at(levels_db_[d], device_time_s(clocks[d], time_s)));
    }
    if (std::ranges::find(now_db, kNothing_db) != now_db.end()) continue;
    for (std::size_t l = 0; l < listeners.size(); ++l) levels_db[l].push_back(now_db[l]);
    times_s.push_back(time_s);
  }
  std::vector<Moment> found;
  if (times_s.empty()) return found;
  const std::vector<float> voice_db = own_voice_levels(levels_db);
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    float loudest = -kBelowVoice_db;
    float second = kNothing_db;
    std::size_t speaker = devices_.size();
    for (std::size_t l = 0; l < listeners.size(); ++l) {
      const float level = levels_db[l][i] - voice_db[l];
      if (level > loudest) {
        if (speaker < devices_.size()) second = loudest;
        loudest = level;
        speaker = listeners[l];
      } else {
        second = std::max(second, level);
      }
    }
    if (speaker < devices_.size() && loudest > second + kAloneBy_db) {
      found.push_back({speaker, times_s[i]});
    }
  }
  return found;
}

std::vector<SoundEvent> VoiceEvents::find(const std::vector<DeviceClock>& clocks, double search_s,
                                          std::size_t most, double until_s,
                                          ProgressSink& progress) const {
  const std::vector<Moment> all = moments(clocks, until_s);
  const std::size_t count = std::min(most, all.size());
  const auto length = static_cast<int>(kEvent_s * kSyncRateHz);
  const auto reach = static_cast<int>(search_s * kSyncRateHz);
  DelayFinder finder(length, 2 * reach, kSyncRateHz);
  std::vector<SoundEvent> events;
  progress.begin("finding voices", static_cast<double>(count), "stretches");
  for (std::size_t i = 0; i < count; ++i) {
    progress.advance(1.0);
    const Moment moment = all[i * all.size() / count];
    const DeviceSound& anchor = devices_[moment.anchor];
    const double anchor_s = device_time_s(clocks[moment.anchor], moment.session_s);
    const auto begin =
        static_cast<std::ptrdiff_t>(std::lround((anchor_s - 0.5 * kEvent_s) * kSyncRateHz));
    const auto voice = samples_at(anchor.sound, 0, begin, length);
    if (voice.empty()) continue;
    finder.set_template(voice);
    SoundEvent event{.anchor = moment.anchor,
                     .anchor_ear = anchor.is_camera ? std::optional(0) : std::nullopt,
                     .anchor_s = (static_cast<double>(begin) + 0.5 * length) / kSyncRateHz,
                     .heard = {}};
    const double session_s = session_time_s(clocks[moment.anchor], event.anchor_s);
    for (std::size_t d = 0; d < devices_.size(); ++d) {
      const DeviceSound& camera = devices_[d];
      if (!camera.is_camera) continue;
      const double travel_s =
          anchor.is_camera
              ? 0.0
              : norm(camera.world_from_head->position_m - centre_m_) / kSoundMetresPerSecond;
      const double expected_s = device_time_s(clocks[d], session_s + travel_s);
      const auto first =
          static_cast<std::ptrdiff_t>(std::lround((expected_s - 0.5 * kEvent_s) * kSyncRateHz)) -
          reach;
      for (int ear = 0; ear < camera.sound.channels(); ++ear) {
        if (d == moment.anchor && ear == event.anchor_ear) continue;
        const auto heard = samples_at(camera.sound, ear, first, length + 2 * reach);
        if (heard.empty()) continue;
        HeardEvent found{.device = d, .ear = ear, .expected_s = expected_s, .times = {}};
        for (const DelayCandidate& candidate : finder.find(heard)) {
          found.times.push_back(
              {(static_cast<double>(first) + candidate.lag_samples + 0.5 * length) / kSyncRateHz,
               candidate.height});
        }
        if (!found.times.empty()) event.heard.push_back(std::move(found));
      }
    }
    events.push_back(std::move(event));
  }
  progress.finish();
  drop_side_peaks(events);
  weigh_by_neighbours(events);
  return events;
}

}  // namespace earpoint
