#include <earpoint/record_simulation/session_pictures.h>

#include "body_outline.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/record_simulation/session_speech.h>
#include <earpoint/scene/scene.h>

namespace earpoint {
namespace {

constexpr int kTile = 8;  // regions begin at multiples: see SceneDrawer::draw_region

/// Small movements of standing people: from time to time they shift their weight, and they sway
/// while they speak.
class Stirring {
 public:
  explicit Stirring(const SessionPlan& plan) : speech_(plan.people.size()) {
    for (const Utterance& turn : plan.turns) {
      for (const SpeechInterval& interval : speech_intervals(turn)) {
        speech_[turn.person].push_back(interval);
      }
    }
  }

  [[nodiscard]] Stance stirred(Stance stance, int person, double time_s) const {
    constexpr double kSpeaking_rad = radians_from_degrees(5.0);
    constexpr double kShift_s = 0.8;
    constexpr double kBetweenShifts_s = 5.0;
    const double phase = 2.4 * person;
    const double quick = std::sin(2.0 * kPi * 0.83 * time_s + 1.7 * phase);
    stance.yaw_rad += speaking(person, time_s) * kSpeaking_rad * quick;
    const double shifts = time_s / kBetweenShifts_s + phase;
    const double number = std::floor(shifts);
    const double done = std::min(1.0, (shifts - number) * kBetweenShifts_s / kShift_s);
    const double eased = 0.5 - 0.5 * std::cos(kPi * done);
    const Stance from = rest(person, static_cast<std::int64_t>(number) - 1);
    const Stance to = rest(person, static_cast<std::int64_t>(number));
    stance.at.x += from.at.x + eased * (to.at.x - from.at.x);
    stance.at.y += from.at.y + eased * (to.at.y - from.at.y);
    stance.yaw_rad += from.yaw_rad + eased * (to.yaw_rad - from.yaw_rad);
    return stance;
  }

 private:
  /// A person's stance between two shifts, relative to the path.
  static Stance rest(int person, std::int64_t number) {
    constexpr double kYaw_rad = radians_from_degrees(2.0);
    constexpr double kStep_m = 0.01;
    RandomStream random(static_cast<std::uint64_t>(person), {static_cast<std::uint64_t>(number)});
    const double x_m = random.uniform(-kStep_m, kStep_m);
    const double y_m = random.uniform(-kStep_m, kStep_m);
    return {{x_m, y_m}, random.uniform(-kYaw_rad, kYaw_rad)};
  }

  /// 1 during speech, with fades of 0.3 s around it; else 0.
  [[nodiscard]] double speaking(int person, double time_s) const {
    constexpr double kFade_s = 0.3;
    double most = 0.0;
    for (const SpeechInterval& interval : speech_[person]) {
      const double outside_s = std::max({interval.begin_s - time_s, time_s - interval.end_s, 0.0});
      most = std::max(most, 1.0 - outside_s / kFade_s);
    }
    return most;
  }

  std::vector<std::vector<SpeechInterval>> speech_;  // by person
};

bool overlap(const PixelRegion& a, const PixelRegion& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

PixelRegion joined(const PixelRegion& a, const PixelRegion& b) {
  const int x = std::min(a.x, b.x);
  const int y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x,
          std::max(a.y + a.height, b.y + b.height) - y};
}

/// The body with a margin for its shadow.
PixelRegion region_of(const BodyOutline& outline, const Camera& camera) {
  constexpr double kMargin = 0.05;  // of the larger side
  const PixelRegion& body = outline.pixels;
  const int margin = kTile + static_cast<int>(kMargin * std::max(body.width, body.height));
  PixelRegion region;
  region.x = std::max(0, body.x - margin) / kTile * kTile;
  region.y = std::max(0, body.y - margin) / kTile * kTile;
  region.width = std::min(camera.width, body.x + body.width + margin) - region.x;
  region.height = std::min(camera.height, body.y + body.height + margin) - region.y;
  return region;
}

/// The regions, with overlapping ones joined.
std::vector<PixelRegion> apart(const std::vector<PixelRegion>& regions) {
  std::vector<PixelRegion> result;
  for (PixelRegion region : regions) {
    for (std::size_t i = 0; i < result.size();) {
      if (!overlap(result[i], region)) {
        ++i;
        continue;
      }
      // The joined region may overlap earlier ones.
      region = joined(result[i], region);
      result.erase(result.begin() + static_cast<std::ptrdiff_t>(i));
      i = 0;
    }
    result.push_back(region);
  }
  return result;
}

/// Share of the region in a pixel, in eighths. At edges inside the picture the region fades into
/// the picture of the empty room, as a shadow may extend beyond it.
int share_of_region(const PixelRegion& region, int x, int y, const Camera& camera) {
  int share = kTile;
  if (region.x > 0) share = std::min(share, x + 1);
  if (region.y > 0) share = std::min(share, y + 1);
  if (region.x + region.width < camera.width) share = std::min(share, region.width - x);
  if (region.y + region.height < camera.height) share = std::min(share, region.height - y);
  return share;
}

/// A camera and its last picture.
struct FilmCamera {
  Camera camera;
  float exposure = 1.0F;
  int first_moment = 0;  ///< the session's moment of its first picture
  int frames = 0;
  Image rgb;
  Raster<std::int32_t> person;  ///< who is seen at the middle of a pixel; -1: nobody
  std::vector<Stance> stances;  ///< by person, as they stand in the picture; empty: the empty room
  std::vector<PixelRegion> regions;  ///< by person, where they are in it; empty where they are not
};

/// The people at their places at one moment.
struct Moment {
  int number = 0;
  std::vector<Stance> stances;
  PeopledScene peopled;
};

/// Takes pictures in the order of time.
class Film {
 public:
  Film(const PreparedScene& scene, const SessionPlan& plan, double frame_rate_hz,
       const SessionPictureQuality& quality, std::uint64_t seed, ThreadPool& pool)
      : scene_(scene),
        plan_(plan),
        frame_rate_hz_(frame_rate_hz),
        quality_{.samples_per_side = quality.samples_per_side},
        seed_(seed),
        stirring_(plan),
        pool_(pool) {
    for (std::size_t i = 0; i < plan.world_from_camera.size(); ++i) {
      FilmCamera& film = cameras_.emplace_back();
      film.camera = {.world_from_camera = plan.world_from_camera[i],
                     .horizontal_fov_rad = quality.horizontal_fov_rad,
                     .width = quality.width,
                     .height = quality.height};
      film.first_moment =
          static_cast<int>(std::floor(plan.clocks[i].offset_s * frame_rate_hz + 1e-9));
      film.frames = frames_of(plan, static_cast<int>(i), frame_rate_hz);
      moments_ = std::max(moments_, film.first_moment + film.frames);
      take_empty_room(film, seed + i);
    }
  }

  [[nodiscard]] int moments() const { return moments_; }

  /// The pictures of all cameras that are running at a moment.
  std::vector<SessionFrame> take(int number) {
    const Moment moment = moment_of(number);
    std::vector<std::size_t> running;
    bool changes = false;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const int frame = number - cameras_[i].first_moment;
      if (frame < 0 || frame >= cameras_[i].frames) continue;
      running.push_back(i);
      changes = changes || cameras_[i].stances != moment.stances;
    }
    std::optional<SceneDrawer> drawer;
    if (changes) drawer = scene_.drawer.extended(moment.peopled.scene, pool_);
    std::vector<SessionFrame> frames(running.size());
    pool_.run(std::ssize(running), [&](std::ptrdiff_t task, int) {
      const std::size_t camera = running[static_cast<std::size_t>(task)];
      frames[static_cast<std::size_t>(task)] =
          take(static_cast<int>(camera), moment, drawer ? &*drawer : nullptr);
    });
    return frames;
  }

 private:
  void take_empty_room(FilmCamera& film, std::uint64_t seed) {
    film.exposure = scene_.drawer.found_exposure(film.camera, quality_, seed, pool_);
    film.rgb =
        scene_.drawer
            .draw_region(film.camera, {.width = film.camera.width, .height = film.camera.height},
                         quality_, film.exposure, seed, pool_)
            .rgb;
    film.person = Raster<std::int32_t>(film.camera.width, film.camera.height, 1, -1);
    film.regions.resize(plan_.people.size());
  }

  [[nodiscard]] Moment moment_of(int number) const {
    const double time_s = number / frame_rate_hz_;
    Moment moment{.number = number, .stances = {}, .peopled = {scene_.scene, {}}};
    for (std::size_t i = 0; i < plan_.people.size(); ++i) {
      const SessionFigure& person = plan_.people[i];
      const Stance stance = stirring_.stirred(person.path.at(time_s), static_cast<int>(i), time_s);
      moment.stances.push_back(stance);
      moment.peopled.people.push_back(add_person(*person.figure, stance.at.x, stance.at.y,
                                                 stance.yaw_rad, moment.peopled.scene));
    }
    return moment;
  }

  SessionFrame take(int index, const Moment& moment, const SceneDrawer* drawer) {
    FilmCamera& film = cameras_[index];
    SessionFrame frame{
        .camera = index, .frame = moment.number - film.first_moment, .rgb = {}, .boxes = {}};
    std::vector<PixelRegion> changed;
    std::vector<int> areas;
    for (std::size_t i = 0; i < moment.stances.size(); ++i) {
      const auto outline =
          outline_of(moment.peopled.scene, moment.peopled.people[i].instance, film.camera);
      const PixelRegion region = outline ? region_of(*outline, film.camera) : PixelRegion{};
      if (film.stances.empty() || !(film.stances[i] == moment.stances[i])) {
        for (const PixelRegion& part : {film.regions[i], region}) {
          if (part.width > 0) changed.push_back(part);
        }
      }
      film.regions[i] = region;
      if (!outline) continue;
      areas.push_back(outline->area);
      frame.boxes.push_back({.camera = index,
                             .frame = frame.frame,
                             .time_s = frame.frame / frame_rate_hz_,
                             .person = static_cast<int>(i),
                             .box = outline->box,
                             .visible = 0.0});
    }
    for (const PixelRegion& region : apart(changed)) retake(film, index, region, moment, *drawer);
    film.stances = moment.stances;
    std::vector<int> seen(moment.stances.size());
    for (const std::int32_t person : film.person.pixels()) {
      if (person >= 0) ++seen[person];
    }
    for (std::size_t i = 0; i < frame.boxes.size(); ++i) {
      const int pixels = seen[frame.boxes[i].person];
      frame.boxes[i].visible = std::min(1.0, static_cast<double>(pixels) / areas[i]);
    }
    frame.rgb = film.rgb;
    return frame;
  }

  void retake(FilmCamera& film, int index, const PixelRegion& region, const Moment& moment,
              const SceneDrawer& drawer) const {
    ThreadPool alone(1);
    const View view = drawer.draw_region(film.camera, region, quality_, film.exposure,
                                         seed_ + static_cast<std::uint64_t>(index), alone);
    const auto first_person = static_cast<std::int32_t>(moment.peopled.people.front().instance);
    for (int y = 0; y < region.height; ++y) {
      for (int x = 0; x < region.width; ++x) {
        const int share = share_of_region(region, x, y, film.camera);
        for (int c = 0; c < 3; ++c) {
          std::uint8_t& pixel = film.rgb.at(region.x + x, region.y + y, c);
          pixel = static_cast<std::uint8_t>(
              (share * view.rgb.at(x, y, c) + (kTile - share) * pixel + kTile / 2) / kTile);
        }
        // People were added last, one after the other.
        film.person.at(region.x + x, region.y + y) =
            std::max(-1, view.instance.at(x, y) - first_person);
      }
    }
  }

  const PreparedScene& scene_;
  const SessionPlan& plan_;
  double frame_rate_hz_;
  RenderQuality quality_;
  std::uint64_t seed_;
  Stirring stirring_;
  ThreadPool& pool_;
  std::vector<FilmCamera> cameras_;
  int moments_ = 0;
};

}  // namespace

int frames_of(const SessionPlan& plan, int camera, double frame_rate_hz) {
  const double end_s = device_time_s(plan.clocks[camera], plan.ends_s[camera]);
  return static_cast<int>(std::floor(end_s * frame_rate_hz));
}

void film_session(const PreparedScene& scene, const SessionPlan& plan, double frame_rate_hz,
                  const SessionPictureQuality& quality, std::uint64_t seed, int jobs,
                  ProgressSink& progress, const std::function<void(const SessionFrame&)>& sink) {
  ThreadPool pool(jobs);
  Film film(scene, plan, frame_rate_hz, quality, seed, pool);
  progress.begin("taking pictures", film.moments(), "moments");
  for (int moment = 0; moment < film.moments(); ++moment) {
    for (const SessionFrame& frame : film.take(moment)) sink(frame);
    progress.advance(1.0);
  }
  progress.finish();
}

}  // namespace earpoint
