#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include <earpoint/plot/draw.h>
#include <earpoint/render_files/locate_speaker.h>

namespace earpoint {
namespace {

constexpr int kSize = 480;
constexpr double kMargin = 40.0;
constexpr Color kPaper{243, 245, 248};
constexpr Color kRing{213, 218, 226};
constexpr Color kInk{29, 36, 48};
constexpr Color kCamera{122, 130, 142};
constexpr Color kSpeaker{224, 142, 43};

/// Places in the source's frame on the page: front is up, left is left.
struct Page {
  Point camera;
  double pixels_per_metre = 1.0;

  [[nodiscard]] Point at(double x_m, double y_m) const {
    return {camera.x - y_m * pixels_per_metre, camera.y - x_m * pixels_per_metre};
  }
};

/// A page that shows all sightings, also those behind the camera.
Page page_for(const LocatedSpeaker& located) {
  double front_m = 1.0, back_m = 0.3, side_m = 1.0;
  const auto include = [&](const Vector3& p) {
    front_m = std::max(front_m, p.x);
    back_m = std::max(back_m, -p.x);
    side_m = std::max(side_m, std::abs(p.y));
  };
  include(located.speaker.position_m);
  for (const SpeakerSighting& sighting : located.sightings) include(sighting.speaker.position_m);
  const double room = kSize - 2 * kMargin;
  const double scale = std::min(room / (front_m + back_m), room / (2 * side_m));
  return {{kSize / 2.0, kSize - kMargin - back_m * scale}, scale};
}

void draw_rings(Image& image, const Page& page) {
  for (int ring = 1; ring * page.pixels_per_metre < kSize; ++ring) {
    std::vector<Point> circle;
    for (int step = 0; step <= 90; ++step) {
      const double angle_rad = 2.0 * kPi * step / 90;
      circle.push_back(page.at(ring * std::cos(angle_rad), ring * std::sin(angle_rad)));
    }
    draw_polyline(image, circle, kRing);
    Point label = page.at(ring, 0);
    label.y -= 3;
    draw_text(image, label, fmt::format("{} m", ring),
              {.size = 11, .color = kCamera, .align = TextAlign::centre});
  }
}

void draw_camera(Image& image, const Page& page, double horizontal_fov_rad) {
  for (const double side : {-0.5, 0.5}) {
    const double angle_rad = side * horizontal_fov_rad;
    draw_line(image, page.at(0, 0), page.at(20 * std::cos(angle_rad), 20 * std::sin(angle_rad)),
              kRing, 2.0);
  }
  draw_polyline(image, std::array{page.at(0, 0)}, kCamera, 14.0);
  Point label = page.at(0, 0);
  label.y += 22;
  draw_text(image, label, "camera", {.size = 12, .color = kInk, .align = TextAlign::centre});
}

}  // namespace

Image plot_speaker(const LocatedSpeaker& located, double horizontal_fov_rad) {
  Image image = filled_image(kSize, kSize, kPaper);
  const Page page = page_for(located);
  draw_rings(image, page);
  draw_camera(image, page, horizontal_fov_rad);
  for (const SpeakerSighting& sighting : located.sightings) {
    const Vector3& p = sighting.speaker.position_m;
    draw_polyline(image, std::array{page.at(p.x, p.y)}, mix(kPaper, kSpeaker, 0.5), 6.0);
  }
  const GtfSpeaker& speaker = located.speaker;
  const Point at = page.at(speaker.position_m.x, speaker.position_m.y);
  // The surer the direction that they face, the longer the line.
  const double length = 16.0 + 24.0 * speaker.yaw_certainty;
  draw_line(image, at,
            {at.x - length * std::sin(speaker.yaw_rad), at.y - length * std::cos(speaker.yaw_rad)},
            kSpeaker, 4.0);
  draw_polyline(image, std::array{at}, kSpeaker, 18.0);
  draw_text(image, {at.x, at.y - 20.0}, "speaker",
            {.size = 12, .color = kInk, .is_bold = true, .align = TextAlign::centre});
  return image;
}

}  // namespace earpoint
