#include <earpoint/locate/plot_people.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/media/media.h>
#include <earpoint/media/movie_writer.h>
#include <earpoint/plot/draw.h>
#include <earpoint/render_files/picture_stream.h>

namespace earpoint {
namespace {

constexpr double kStillRate_hz = 5.0;
constexpr double kFastestRate_hz = 30.0;
constexpr std::ptrdiff_t kSoundBlock = 16384;
constexpr Color kSilent{150, 160, 172};
constexpr Color kSpeaking{224, 142, 43};
constexpr Color kShade{29, 36, 48};
constexpr Color kPaper{255, 255, 255};

void draw_dashes(Image& picture, Point from, Point to, Color color, double width) {
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  const double dash = 4.0 * width;
  const auto at = [&](double way) {
    const double share = std::min(way / length, 1.0);
    return Point{from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)};
  };
  for (double way = 0.0; way < length; way += 2.0 * dash) {
    draw_line(picture, at(way), at(way + dash), color, width);
  }
}

void draw_person(Image& picture, const TrackedPerson& person, double speaking) {
  const double scale = std::max(picture.height(), 120) / 360.0;
  const Color color = mix(kSilent, kSpeaking, speaking);
  const double width = (1.0 + 2.0 * speaking) * scale;
  const double left = person.box.x_min * picture.width();
  const double right = person.box.x_max * picture.width();
  const double top = person.box.y_min * picture.height();
  const double bottom = person.box.y_max * picture.height();
  const std::array<Point, 5> corners{Point{left, top}, Point{right, top}, Point{right, bottom},
                                     Point{left, bottom}, Point{left, top}};
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    if (person.is_seen) {
      draw_line(picture, corners[i], corners[i + 1], color, width);
    } else {
      draw_dashes(picture, corners[i], corners[i + 1], color, width);
    }
  }
  const TextStyle style{.size = 14.0 * scale, .color = kPaper, .is_bold = true};
  const std::string label = fmt::format("{}  {:.0f} %", person.track, 100.0 * speaking);
  const int tag_width = static_cast<int>(text_width(label, style) + 8.0 * scale);
  const int tag_height = static_cast<int>(18.0 * scale);
  const int tag_x = static_cast<int>(left);
  const int tag_y = std::max(static_cast<int>(top) - tag_height, 0);
  fill_rect(picture, {tag_x, tag_y, tag_width, tag_height}, kShade, 0.6);
  fill_rect(picture, {tag_x, tag_y, static_cast<int>(tag_width * speaking), tag_height}, kSpeaking,
            0.8);
  draw_text(picture, {tag_x + 4.0 * scale, tag_y + 14.0 * scale}, label, style);
}

const PeopleFrame& nearest_frame(const PeopleInClip& people, double time_s) {
  const auto after = std::ranges::lower_bound(people.frames, time_s, {}, &PeopleFrame::time_s);
  if (after == people.frames.begin()) return *after;
  const auto before = std::prev(after);
  if (after == people.frames.end()) return *before;
  return time_s - before->time_s <= after->time_s - time_s ? *before : *after;
}

double picture_rate_hz(const RenderInput& source) {
  const MediaInfo info = probe_media(source.picture.value_or(source.sound.path));
  const StreamInfo* picture = info.preferred(StreamKind::video);
  if (info.kind != MediaKind::movie || picture == nullptr) return kStillRate_hz;
  return picture->frame_rate_hz > 0.0 ? std::min(picture->frame_rate_hz, kFastestRate_hz)
                                      : kStillRate_hz;
}

}  // namespace

void draw_people(Image& picture, const PeopleFrame& frame) {
  // The speaker last, on top of the others.
  std::vector<std::size_t> order(frame.people.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](std::size_t person) { return frame.speaking(person); });
  for (const std::size_t i : order) draw_person(picture, frame.people[i], frame.speaking(i));
  const double outside = frame.belief.voice * frame.belief.outside;
  if (outside < 0.5) return;
  const double scale = std::max(picture.height(), 120) / 360.0;
  const TextStyle style{.size = 14.0 * scale, .color = kPaper, .align = TextAlign::centre};
  const int height = static_cast<int>(20.0 * scale);
  fill_rect(picture, {0, picture.height() - height, picture.width(), height}, kShade, 0.7);
  draw_text(picture, {picture.width() / 2.0, picture.height() - 6.0 * scale},
            "the speaker is not in the picture", style);
}

void write_people_movie(const std::filesystem::path& path, const RenderInput& source,
                        const PeopleInClip& people, ProgressSink& progress) {
  PictureStream pictures = open_pictures(source.picture, source.sound.path);
  if (pictures.empty()) {
    throw InputError(source.sound.path.string(), "has no picture to draw boxes into",
                     "give a movie, or a picture before the sound; a .png is a map from above");
  }
  AudioReader sound(source.sound.path, source.sound.binaural_channels, source.sound.audio_stream);
  const double rate_hz = picture_rate_hz(source);
  std::optional<MovieWriter> movie;
  const double duration_s =
      2.0 * people.frames.back().time_s -
      (people.frames.size() > 1 ? people.frames[people.frames.size() - 2].time_s : 0.0);
  const auto count = std::max<std::ptrdiff_t>(1, std::llround(duration_s * rate_hz));
  progress.begin("drawing people", static_cast<double>(count), "pictures");
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double time_s = static_cast<double>(i) / rate_hz;
    Image picture = *pictures.nearest(time_s);
    draw_people(picture, nearest_frame(people, time_s));
    if (!movie) {
      movie.emplace(path, picture.width(), picture.height(), rate_hz, sound.sample_rate_hz());
    }
    movie->write_picture(picture);
    progress.advance(1.0);
  }
  for (Waveform block = sound.read(kSoundBlock); block.samples() > 0;
       block = sound.read(kSoundBlock)) {
    movie->write_sound(block);
  }
  movie->close();
  progress.finish();
}

}  // namespace earpoint
