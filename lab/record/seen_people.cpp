#include "seen_people.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kBoxAge_s = 0.3;  ///< or half of the time between pictures, if longer
constexpr double kVoiceAge_s = 1.0;
constexpr double kLeastVisible = 0.1;
// A body around a mouth, in metres; of seated people the picture's edge or a table hides the rest.
constexpr double kAboveMouth_m = 0.22;
constexpr double kBelowMouth_m = 1.1;
constexpr double kHalfWidth_m = 0.28;

/// Shortest time between two boxes of the same person; 0 if there are none. Boxes are sorted by
/// time.
double shortest_gap_s(const std::vector<std::vector<PersonBox>>& boxes) {
  double shortest_s = 0.0;
  for (const std::vector<PersonBox>& person : boxes) {
    for (std::size_t i = 1; i < person.size(); ++i) {
      const double gap_s = person[i].time_s - person[i - 1].time_s;
      if (gap_s > 0.0 && (shortest_s == 0.0 || gap_s < shortest_s)) shortest_s = gap_s;
    }
  }
  return shortest_s;
}

}  // namespace

std::optional<SeenPoint> project(const Vector3& point_m, const Lens& lens,
                                 const Pose& world_from_camera) {
  const Vector3 p = transform_point(inverse(world_from_camera), point_m);
  constexpr double kNearest_m = 0.05;
  if (p.x < kNearest_m) return std::nullopt;
  // OpenCV's axes: right and down, over the distance ahead.
  const double x = -p.y / p.x;
  const double y = -p.z / p.x;
  const double r2 = x * x + y * y;
  const auto k = [&](std::size_t i) {
    return i < lens.distortion.size() ? lens.distortion[i] : 0.0;
  };
  const double radial =
      (1.0 + r2 * (k(0) + r2 * (k(1) + r2 * k(4)))) / (1.0 + r2 * (k(5) + r2 * (k(6) + r2 * k(7))));
  const double u = x * radial + 2.0 * k(2) * x * y + k(3) * (r2 + 2.0 * x * x);
  const double v = y * radial + k(2) * (r2 + 2.0 * y * y) + 2.0 * k(3) * x * y;
  const SeenPoint seen{(lens.fx_px * u + lens.cx_px) / lens.width_px,
                       (lens.fy_px * v + lens.cy_px) / lens.height_px};
  if (seen.x < 0.0 || seen.x > 1.0 || seen.y < 0.0 || seen.y > 1.0) return std::nullopt;
  return seen;
}

SeenPeople::SeenPeople(const Session& session, const SyncResult& sync)
    : session_(session),
      clocks_(session.cameras.size()),
      voices_(session.people.size()),
      boxes_(session.cameras.size(), std::vector<std::vector<PersonBox>>(session.people.size())),
      wearers_(session.people.size()) {
  std::iota(wearers_.begin(), wearers_.end(), std::size_t{0});
  for (std::size_t c = 0; c < session.cameras.size(); ++c) {
    if (const SyncedDevice* device = sync.find(session.cameras[c].name)) clocks_[c] = device->clock;
  }
  for (const LocatedVoice& voice : sync.voices) {
    const std::string& name = sync.devices[voice.device].clock.name;
    for (std::size_t m = 0; m < session.people.size(); ++m) {
      if (session.people[m].name == name) voices_[m].push_back({voice.time_s, voice.mouth_m});
    }
  }
  const auto person_called = [&](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(session.people, name, &SessionPerson::name) -
                                    session.people.begin());
  };
  for (const MicrophoneWearer& wearer : sync.wearers) {
    const std::size_t microphone = person_called(wearer.microphone);
    const std::size_t person = person_called(wearer.person);
    if (microphone < wearers_.size() && person < wearers_.size()) wearers_[microphone] = person;
  }
  if (!session.boxes) return;
  for (const PersonBox& box : read_person_boxes(*session.boxes)) {
    const auto camera = static_cast<std::size_t>(box.camera);
    const auto person = static_cast<std::size_t>(box.person);
    if (box.camera < 0 || camera >= boxes_.size() || box.person < 0 ||
        person >= session.people.size()) {
      throw InputError(session.boxes->string(),
                       fmt::format("names camera {} and person {}, which the session does not have",
                                   box.camera, box.person));
    }
    if (box.visible >= kLeastVisible) boxes_[camera][person].push_back(box);
  }
  for (auto& camera : boxes_) {
    for (auto& person : camera) std::ranges::stable_sort(person, {}, &PersonBox::time_s);
    box_ages_s_.push_back(std::max(kBoxAge_s, 0.51 * shortest_gap_s(camera)));
  }
}

const PersonBox* SeenPeople::seen_box(std::size_t person, std::size_t camera, double time_s) const {
  const std::vector<PersonBox>& boxes = boxes_[camera][person];
  if (boxes.empty() || !clocks_[camera]) return nullptr;
  const double device_s = device_time_s(*clocks_[camera], time_s);
  const auto after = std::ranges::lower_bound(boxes, device_s, {}, &PersonBox::time_s);
  const PersonBox* nearest = after == boxes.end() ? &boxes.back() : &*after;
  if (after != boxes.begin() &&
      device_s - std::prev(after)->time_s < std::abs(nearest->time_s - device_s)) {
    nearest = &*std::prev(after);
  }
  return std::abs(nearest->time_s - device_s) <= box_ages_s_[camera] ? nearest : nullptr;
}

std::optional<Vector3> SeenPeople::mouth(std::size_t microphone, double time_s) const {
  // Median of each coordinate over the positions found around that time.
  std::array<std::vector<double>, 3> around;
  for (const Voice& voice : voices_[microphone]) {
    if (std::abs(voice.time_s - time_s) > kVoiceAge_s) continue;
    around[0].push_back(voice.mouth_m.x);
    around[1].push_back(voice.mouth_m.y);
    around[2].push_back(voice.mouth_m.z);
  }
  if (around[0].empty()) return nearest_mouth(microphone, time_s);
  for (auto& values : around) {
    std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
  }
  const auto middle = around[0].size() / 2;
  return Vector3{around[0][middle], around[1][middle], around[2][middle]};
}

std::optional<Vector3> SeenPeople::nearest_mouth(std::size_t microphone, double time_s) const {
  const Voice* nearest = nullptr;
  for (const Voice& voice : voices_[microphone]) {
    if (nearest == nullptr ||
        std::abs(voice.time_s - time_s) < std::abs(nearest->time_s - time_s)) {
      nearest = &voice;
    }
  }
  return nearest == nullptr ? std::nullopt : std::optional(nearest->mouth_m);
}

std::optional<Box> SeenPeople::box(std::size_t microphone, std::size_t camera,
                                   double time_s) const {
  if (session_.boxes) {
    const PersonBox* seen = seen_box(wearers_[microphone], camera, time_s);
    return seen == nullptr ? std::nullopt : std::optional(seen->box);
  }
  const SessionCamera& from = session_.cameras[camera];
  const auto mouth_m = mouth(microphone, time_s);
  if (!mouth_m || !from.lens || !from.world_from_camera) return std::nullopt;
  const auto seen = project(*mouth_m, *from.lens, *from.world_from_camera);
  if (!seen) return std::nullopt;
  // Sizes follow from the distance ahead; lens distortion is applied only to the mouth.
  const double ahead_m = transform_point(inverse(*from.world_from_camera), *mouth_m).x;
  const double width = from.lens->fx_px / ahead_m / from.lens->width_px;
  const double height = from.lens->fy_px / ahead_m / from.lens->height_px;
  return Box{.x_min = std::max(0.0, seen->x - kHalfWidth_m * width),
             .y_min = std::max(0.0, seen->y - kAboveMouth_m * height),
             .x_max = std::min(1.0, seen->x + kHalfWidth_m * width),
             .y_max = std::min(1.0, seen->y + kBelowMouth_m * height)};
}

}  // namespace earpoint
