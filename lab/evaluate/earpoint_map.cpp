#include "earpoint_map.h"

#include "report_sounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>
#include <earpoint/plot/draw.h>
#include <earpoint/plot/plot.h>

namespace earpoint {
namespace {

constexpr Color kWhite{255, 255, 255};
constexpr Color kInk{29, 36, 48};
constexpr Color kEarpointColor{37, 99, 168};
constexpr Color kSpeakerColor{224, 142, 43};
constexpr double kHeadRadius = 12.0;

void draw_dot(Image& image, Point at, double radius, Color color) {
  draw_polyline(image, {&at, 1}, color, 2.0 * radius);
}

/// From metres in the source's frame, whose front is up the page, to pixels.
class MapFrame {
 public:
  explicit MapFrame(const MapPicture& map) : map_(map) {}

  [[nodiscard]] Point at(const Vector3& place_m) const {
    return {map_.camera_x - place_m.y * map_.pixels_per_metre,
            map_.camera_y - place_m.x * map_.pixels_per_metre};
  }

 private:
  const MapPicture& map_;
};

/// A point some pixels away, in a direction of the source's frame.
Point moved(Point from, double pixels, double yaw_rad) {
  return {from.x - pixels * std::sin(yaw_rad), from.y - pixels * std::cos(yaw_rad)};
}

/// A head from above: a disc with a nose and two ears, outlined in white.
void draw_head(Image& image, Point at, double yaw_rad, Color color) {
  const Point nose = moved(at, kHeadRadius + 7.0, yaw_rad);
  const std::array<Point, 2> ears{moved(at, kHeadRadius, yaw_rad + kPi / 2.0),
                                  moved(at, kHeadRadius, yaw_rad - kPi / 2.0)};
  const auto draw = [&](double grown, Color with) {
    draw_line(image, at, nose, with, 6.0 + 2.0 * grown);
    for (const Point& ear : ears) draw_dot(image, ear, 4.0 + grown, with);
    draw_dot(image, at, kHeadRadius + grown, with);
  };
  draw(2.0, kWhite);
  draw(0.0, color);
}

void draw_label(Image& image, Point at, std::string_view text) {
  const TextStyle style{.size = 15.0, .color = kInk, .align = TextAlign::centre};
  const int width = static_cast<int>(text_width(text, style)) + 10;
  fill_rect(image, {static_cast<int>(at.x) - width / 2, static_cast<int>(at.y) - 14, width, 19},
            kWhite, 0.85);
  draw_text(image, at, text, style);
}

/// Two pictures one below the other, aligned at the left.
Image stacked(const Image& above, const Image& below) {
  Image canvas =
      filled_image(std::max(above.width(), below.width()), above.height() + below.height(), kWhite);
  paste(canvas, above, 0, 0);
  paste(canvas, below, 0, above.height());
  return canvas;
}

/// Two pictures side by side, aligned at the top.
Image side_by_side(const Image& left, const Image& right) {
  Image canvas =
      filled_image(left.width() + right.width(), std::max(left.height(), right.height()), kWhite);
  paste(canvas, left, 0, 0);
  paste(canvas, right, left.width(), 0);
  return canvas;
}

}  // namespace

Image drawn_map(const EarpointClip& clip, std::optional<std::size_t> only) {
  EARPOINT_CHECK(clip.map.has_value());
  Image image = read_image(clip.map->picture);
  const MapFrame frame(*clip.map);
  const Point camera = frame.at({});
  const double half_fov_rad = radians_from_degrees(clip.fov_deg.value_or(90.0) / 2.0);
  for (const double side : {-1.0, 1.0}) {
    draw_line(image, camera, moved(camera, 70.0, side * half_fov_rad), kWhite, 2.0);
  }
  draw_head(image, camera, 0.0, kInk);
  draw_label(image, {camera.x, camera.y + 34.0}, "camera");
  if (clip.speaker_m) {
    const Point speaker = frame.at(*clip.speaker_m);
    draw_dot(image, speaker, 11.0, kWhite);
    draw_dot(image, speaker, 9.0, kSpeakerColor);
    draw_label(image, {speaker.x, speaker.y - 22.0}, "speaker");
  }
  for (std::size_t i = 0; i < clip.earpoints.size(); ++i) {
    if (only && *only != i) continue;
    const KnownEarpoint& earpoint = clip.earpoints[i];
    const Point at = frame.at(earpoint.source_from_target.position_m);
    draw_head(image, at, radians_from_degrees(earpoint.yaw_deg), kEarpointColor);
    draw_text(image, {at.x, at.y + 6.0}, std::to_string(i + 1),
              {.size = 17.0, .color = kWhite, .is_bold = true, .align = TextAlign::centre});
  }
  return image;
}

Image clip_picture(const EarpointClip& clip) {
  const MediaInfo info = probe_media(clip.clip);
  if (info.preferred(StreamKind::video) == nullptr) return {};
  return boxed(FrameReader(clip.clip).frame_nearest(info.duration_s.value_or(0.0) / 2.0),
               clip.speaker_box);
}

Image overview(const EarpointComparison& comparison) {
  constexpr int kWidthWithoutPicture = 960;
  constexpr int kNarrowest = 400;
  const Image picture = clip_picture(comparison.clip);
  const int width = picture.empty() ? kWidthWithoutPicture : std::max(kNarrowest, picture.width());
  std::vector<WaveformPanel> panels{
      {"at the camera", WaveformOutline(read_sound(comparison.source))}};
  for (std::size_t i = 0; i < comparison.earpoints.size(); ++i) {
    const Waveform sound = read_sound(comparison.earpoints[i].renderings.back().sound);
    panels.push_back(
        {fmt::format("{}  {}", i + 1, comparison.clip.earpoints[i].name), WaveformOutline(sound)});
  }
  const Image waveforms =
      plot_waveforms(panels, fmt::format("rendered by {}", comparison.methods.back().name), width);
  const Image left = picture.empty() ? waveforms : stacked(picture, waveforms);
  return comparison.clip.map ? side_by_side(left, drawn_map(comparison.clip)) : left;
}

}  // namespace earpoint
