#include <earpoint/record/session_sync.h>

#include "own_voice.h"
#include "seen_people.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/locate/microphone_map.h>

namespace earpoint {
namespace {

constexpr double kMoment_s = 1.0;
constexpr float kSilence_db = -20.0F;  ///< re a wearer's voice
constexpr double kSure = 0.8;          ///< needed to report a swap, and to omit the advice

/// A second of a device's sound.
float level_db(const DeviceSound& device, const DeviceClock& clock, double time_s) {
  const auto begin = std::lround(device_time_s(clock, time_s) * kSyncRateHz);
  const auto length = std::lround(kMoment_s * kSyncRateHz);
  if (begin < 0 || begin + length > device.sound.samples()) return -120.0F;
  double sum = 1e-12;
  for (int c = 0; c < device.sound.channels(); ++c) {
    for (const float x : device.sound.channel(c).subspan(begin, length)) {
      sum += static_cast<double>(x) * x;
    }
  }
  return static_cast<float>(10.0 * std::log10(sum / static_cast<double>(length)));
}

/// The moments of a session with the input of match_microphones().
class Moments {
 public:
  Moments(const Session& session, const DeviceSounds& sounds, const SyncResult& sync)
      : session_(session), sync_(sync), people_(session, sync) {
    for (const DeviceSound& device : sounds.devices) {
      const SyncedDevice* synced = sync.find(device.name);
      if (synced == nullptr) continue;
      if (!device.is_camera) microphones_.push_back({&device, synced->clock});
      if (device.world_from_head) cameras_.push_back({&device, synced->clock});
    }
    const double end_s = sounds.devices.front().sound.duration_s() - kMoment_s;
    std::vector<std::vector<float>> near_db(microphones_.size());
    for (double time_s = 0.0; time_s < end_s; time_s += kMoment_s) {
      times_s_.push_back(time_s);
      for (std::size_t m = 0; m < microphones_.size(); ++m) {
        near_db[m].push_back(level_db(*microphones_[m].sound, microphones_[m].clock, time_s));
      }
    }
    if (microphones_.empty() || times_s_.empty()) return;
    const std::vector<float> voices_db = own_voice_levels(near_db);
    for (std::size_t i = 0; i < times_s_.size(); ++i) {
      std::vector<double> re_voice_db;
      for (std::size_t m = 0; m < microphones_.size(); ++m) {
        re_voice_db.push_back(near_db[m][i] - voices_db[m]);
      }
      add(times_s_[i], re_voice_db);
    }
  }

  [[nodiscard]] std::size_t microphones() const { return microphones_.size(); }
  [[nodiscard]] const std::string& microphone(std::size_t m) const {
    return microphones_[m].sound->name;
  }
  [[nodiscard]] const std::vector<NearRangeMoment>& all() const { return moments_; }

 private:
  struct Device {
    const DeviceSound* sound;
    DeviceClock clock;
  };

  /// Adds one moment for each camera; only the first has the direction of the voice.
  void add(double time_s, const std::vector<double>& re_voice_db) {
    const auto speaker = loudest_microphone(re_voice_db, kSilence_db);
    if (!speaker) return;
    const double middle_s = time_s + 0.5 * kMoment_s;
    std::vector<std::optional<Vector3>> places;
    for (std::size_t p = 0; p < session_.people.size(); ++p) {
      places.push_back(place_of(p, middle_s));
    }
    bool first = true;
    for (const Device& camera : cameras_) {
      NearRangeMoment moment{.near_db = re_voice_db,
                             .camera_db = level_db(*camera.sound, camera.clock, time_s),
                             .distance_m = {}};
      for (const std::optional<Vector3>& place : places) {
        moment.distance_m.push_back(place ? std::optional(horizontal_distance_m(
                                                *place, camera.sound->world_from_head->position_m))
                                          : std::nullopt);
      }
      if (first) moment.direction_log_likelihood = likelihoods(*speaker, middle_s, places);
      first = false;
      moments_.push_back(std::move(moment));
    }
  }

  static double horizontal_distance_m(const Vector3& a, const Vector3& b) {
    return std::hypot(a.x - b.x, a.y - b.y);
  }

  /// Where a person stands: the point nearest to the lines of sight of all cameras that see them.
  [[nodiscard]] std::optional<Vector3> place_of(std::size_t person, double time_s) const {
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
    double bx = 0.0;
    double by = 0.0;
    for (std::size_t c = 0; c < session_.cameras.size(); ++c) {
      const SessionCamera& camera = session_.cameras[c];
      const PersonBox* seen = people_.seen_box(person, c, time_s);
      if (seen == nullptr || !camera.lens || !camera.world_from_camera) continue;
      const double column = 0.5 * (seen->box.x_min + seen->box.x_max) * camera.lens->width_px;
      const Vector3 towards =
          rotate(camera.world_from_camera->orientation,
                 {1.0, -(column - camera.lens->cx_px) / camera.lens->fx_px, 0.0});
      const double length = std::hypot(towards.x, towards.y);
      if (length < 1e-6) continue;
      // The line's normal; the distance from it counts.
      const double nx = -towards.y / length;
      const double ny = towards.x / length;
      const Vector3& at = camera.world_from_camera->position_m;
      const double along = nx * at.x + ny * at.y;
      xx += nx * nx;
      xy += nx * ny;
      yy += ny * ny;
      bx += nx * along;
      by += ny * along;
    }
    const double determinant = xx * yy - xy * xy;
    constexpr double kLeast = 0.05;  // nearly parallel lines of sight have no useful intersection
    if (determinant < kLeast) return std::nullopt;
    return Vector3{(yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant, 0.0};
  }

  /// For each person, the log likelihood that the voice in a microphone is theirs; empty if it was
  /// not located.
  [[nodiscard]] std::vector<double> likelihoods(
      std::size_t microphone, double time_s,
      const std::vector<std::optional<Vector3>>& places) const {
    constexpr double kDeviation_m = 0.4;  // between mouths and the middles of bodies
    constexpr double kLeastLog = -8.0;    // a voice may be located wrongly
    const LocatedVoice* voice = nullptr;
    for (const LocatedVoice& located : sync_.voices) {
      if (sync_.devices[located.device].clock.name != microphones_[microphone].sound->name) {
        continue;
      }
      const double away_s = std::abs(located.time_s - time_s);
      if (away_s < 0.5 * kMoment_s &&
          (voice == nullptr || away_s < std::abs(voice->time_s - time_s))) {
        voice = &located;
      }
    }
    std::vector<double> logs;
    if (voice == nullptr) return logs;
    for (const std::optional<Vector3>& place : places) {
      const double off = place ? horizontal_distance_m(*place, voice->mouth_m) / kDeviation_m : 1e3;
      logs.push_back(std::max(kLeastLog, -0.5 * off * off));
    }
    return logs;
  }

  const Session& session_;
  const SyncResult& sync_;
  SeenPeople people_;
  std::vector<Device> cameras_;
  std::vector<Device> microphones_;
  std::vector<double> times_s_;
  std::vector<NearRangeMoment> moments_;
};

const SessionPerson& person_called(const Session& session, const std::string& name) {
  return *std::ranges::find(session.people, name, &SessionPerson::name);
}

std::string note_of(const Session& session, const MicrophoneWearer& wearer) {
  const std::string file = person_called(session, wearer.microphone).near.filename().string();
  if (session.wearers_known) {
    return fmt::format(
        "near microphones are swapped: the voice in {} comes from where {} is seen and is taken as "
        "theirs",
        file, wearer.person);
  }
  return fmt::format("{} is worn by {}, {:.0f} % sure{}", file, wearer.person,
                     100.0 * wearer.certainty,
                     wearer.certainty < kSure ? "; give every person's near if that is wrong" : "");
}

void find_wearers(const Session& session, const DeviceSounds& sounds, SyncResult& sync) {
  if (!session.boxes || session.people.size() < 2) return;
  const Moments moments(session, sounds, sync);
  const MicrophoneMap map = match_microphones(moments.all(), kSilence_db);
  std::vector<MicrophoneWearer> found;
  bool sure = true;
  for (std::size_t m = 0; m < map.person_of.size(); ++m) {
    if (!map.person_of[m]) continue;
    found.push_back(
        {moments.microphone(m), session.people[*map.person_of[m]].name, map.certainty[m]});
    const bool as_told = found.back().microphone == found.back().person;
    sure = sure && (as_told || map.certainty[m] >= kSure);
  }
  // The session's wearers are kept unless boxes clearly contradict.
  if (session.wearers_known && !sure) return;
  for (const MicrophoneWearer& wearer : found) {
    if (session.wearers_known && wearer.microphone == wearer.person) continue;
    sync.notes.push_back(note_of(session, wearer));
  }
  sync.wearers = std::move(found);
}

}  // namespace

SyncResult synchronize_session(const Session& session, const DeviceSounds& sounds,
                               ProgressSink& progress) {
  SyncResult result =
      synchronize(sounds, {.clap_s = session.clap_s, .clap_m = session.clap_m}, progress);
  find_wearers(session, sounds, result);
  return result;
}

}  // namespace earpoint
