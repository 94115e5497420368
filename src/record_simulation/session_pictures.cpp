#include "body_outline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <earpoint/core/error.h>
#include <earpoint/core/parallel.h>
#include <earpoint/record_simulation/session_pictures.h>
#include <earpoint/scene/scene.h>

namespace earpoint {
namespace {

constexpr int kTile = 8;  // regions begin at multiples: see SceneRenderer::render_region

/// How people stir where they stand: slow swings of the body, wider while they speak.
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
    constexpr double kIdle_rad = radians_from_degrees(1.0);
    constexpr double kSpeaking_rad = radians_from_degrees(5.0);
    constexpr double kStep_m = 0.008;
    const double speaks = speaking(person, time_s);
    const double phase = 2.4 * person;
    const double slow = std::sin(2.0 * kPi * 0.17 * time_s + phase);
    const double quick = std::sin(2.0 * kPi * 0.83 * time_s + 1.7 * phase);
    stance.yaw_rad += kIdle_rad * slow + speaks * kSpeaking_rad * quick;
    stance.at.x += kStep_m * slow * std::cos(phase);
    stance.at.y += kStep_m * slow * std::sin(phase);
    return stance;
  }

 private:
  /// From 0 to 1, up and down within 0.3 s around speech.
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
  constexpr double kMargin = 0.12;  // of the larger side
  const PixelRegion& body = outline.pixels;
  const int margin = kTile + static_cast<int>(kMargin * std::max(body.width, body.height));
  PixelRegion region;
  region.x = std::max(0, body.x - margin) / kTile * kTile;
  region.y = std::max(0, body.y - margin) / kTile * kTile;
  region.width = std::min(camera.width, body.x + body.width + margin) - region.x;
  region.height = std::min(camera.height, body.y + body.height + margin) - region.y;
  return region;
}

/// Regions that do not overlap: those that do are joined.
std::vector<PixelRegion> apart(const std::vector<PixelRegion>& regions) {
  std::vector<PixelRegion> result;
  for (PixelRegion region : regions) {
    for (std::size_t i = 0; i < result.size();) {
      if (!overlap(result[i], region)) {
        ++i;
        continue;
      }
      // What is larger may reach those that were looked at before.
      region = joined(result[i], region);
      result.erase(result.begin() + static_cast<std::ptrdiff_t>(i));
      i = 0;
    }
    result.push_back(region);
  }
  return result;
}

/// How much of a pixel is the region's, in eighths: at the edges inside of the picture it fades
/// into the picture of the empty room, where the light of a shadow may not yet have ended.
int share_of_region(const PixelRegion& region, int x, int y, const Camera& camera) {
  int share = kTile;
  if (region.x > 0) share = std::min(share, x + 1);
  if (region.y > 0) share = std::min(share, y + 1);
  if (region.x + region.width < camera.width) share = std::min(share, region.width - x);
  if (region.y + region.height < camera.height) share = std::min(share, region.height - y);
  return share;
}

/// A camera, its exposure and its picture of the empty room.
struct FilmCamera {
  Camera camera;
  float exposure = 1.0F;
  Image empty_room;
  int first_moment = 0;  ///< the session's moment of its first picture
  int frames = 0;
};

/// Takes pictures; const calls may come from many threads.
class Film {
 public:
  Film(const PreparedScene& scene, const SessionPlan& plan, double frame_rate_hz,
       const SessionPictureQuality& quality, std::uint64_t seed)
      : scene_(scene),
        plan_(plan),
        frame_rate_hz_(frame_rate_hz),
        quality_{.samples_per_side = quality.samples_per_side},
        seed_(seed),
        stirring_(plan) {
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
    }
  }

  [[nodiscard]] int moments() const { return moments_; }

  void take_empty_room(ThreadPool& pool) {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      FilmCamera& film = cameras_[i];
      film.exposure = scene_.renderer.found_exposure(film.camera, quality_, seed_ + i, pool);
      film.empty_room =
          scene_.renderer
              .render_region(film.camera,
                             {.width = film.camera.width, .height = film.camera.height}, quality_,
                             film.exposure, seed_ + i, pool)
              .rgb;
    }
  }

  /// The pictures of all cameras that run at a moment.
  [[nodiscard]] std::vector<SessionFrame> take(int moment) const {
    ThreadPool pool(1);
    PeopledStage stage = stage_at(static_cast<double>(moment) / frame_rate_hz_);
    const SceneRenderer renderer = scene_.renderer.extended(stage.scene, pool);
    std::vector<SessionFrame> frames;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const int frame = moment - cameras_[i].first_moment;
      if (frame < 0 || frame >= cameras_[i].frames) continue;
      frames.push_back(take(static_cast<int>(i), frame, stage, renderer, pool));
    }
    return frames;
  }

 private:
  struct PeopledStage {
    Scene scene;
    std::vector<std::uint32_t> instances;  // by person
  };

  [[nodiscard]] PeopledStage stage_at(double time_s) const {
    PeopledStage stage{.scene = scene_.scene, .instances = {}};
    for (std::size_t i = 0; i < plan_.people.size(); ++i) {
      const SessionFigure& person = plan_.people[i];
      const Stance stance = stirring_.stirred(person.path.at(time_s), static_cast<int>(i), time_s);
      stage.instances.push_back(
          add_person(*person.figure, stance.at.x, stance.at.y, stance.yaw_rad, stage.scene)
              .instance);
    }
    return stage;
  }

  [[nodiscard]] SessionFrame take(int index, int number, const PeopledStage& stage,
                                  const SceneRenderer& renderer, ThreadPool& pool) const {
    const FilmCamera& film = cameras_[index];
    SessionFrame frame{.camera = index, .frame = number, .rgb = film.empty_room, .boxes = {}};
    std::vector<PixelRegion> regions;
    std::vector<int> areas;
    for (std::size_t person = 0; person < stage.instances.size(); ++person) {
      const auto outline = outline_of(stage.scene, stage.instances[person], film.camera);
      if (!outline) continue;
      regions.push_back(region_of(*outline, film.camera));
      areas.push_back(outline->area);
      frame.boxes.push_back({.camera = index,
                             .frame = number,
                             .time_s = number / frame_rate_hz_,
                             .person = static_cast<int>(person),
                             .box = outline->box,
                             .visible = 0.0});
    }
    std::vector<std::int64_t> seen(stage.scene.instances.size());
    for (const PixelRegion& region : apart(regions)) {
      const View view = renderer.render_region(film.camera, region, quality_, film.exposure,
                                               seed_ + static_cast<std::uint64_t>(index), pool);
      for (int y = 0; y < region.height; ++y) {
        for (int x = 0; x < region.width; ++x) {
          const int share = share_of_region(region, x, y, film.camera);
          for (int c = 0; c < 3; ++c) {
            std::uint8_t& pixel = frame.rgb.at(region.x + x, region.y + y, c);
            pixel = static_cast<std::uint8_t>(
                (share * view.rgb.at(x, y, c) + (kTile - share) * pixel + kTile / 2) / kTile);
          }
          if (view.instance.at(x, y) >= 0) ++seen[view.instance.at(x, y)];
        }
      }
    }
    for (std::size_t i = 0; i < frame.boxes.size(); ++i) {
      const auto pixels = seen[stage.instances[frame.boxes[i].person]];
      frame.boxes[i].visible = std::min(1.0, static_cast<double>(pixels) / areas[i]);
    }
    return frame;
  }

  const PreparedScene& scene_;
  const SessionPlan& plan_;
  double frame_rate_hz_;
  RenderQuality quality_;
  std::uint64_t seed_;
  Stirring stirring_;
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
  Film film(scene, plan, frame_rate_hz, quality, seed);
  film.take_empty_room(pool);
  progress.begin("taking pictures", film.moments(), "moments");
  for (int first = 0; first < film.moments(); first += jobs) {
    const int count = std::min(jobs, film.moments() - first);
    std::vector<std::vector<SessionFrame>> taken(static_cast<std::size_t>(count));
    pool.run(count, [&](std::ptrdiff_t task, int) {
      taken[static_cast<std::size_t>(task)] = film.take(first + static_cast<int>(task));
      progress.advance(1.0);
    });
    for (const std::vector<SessionFrame>& moment : taken) {
      for (const SessionFrame& frame : moment) sink(frame);
    }
  }
  progress.finish();
}

}  // namespace earpoint
