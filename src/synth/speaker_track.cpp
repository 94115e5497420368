#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/csv.h>
#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/synth/speaker_track.h>

namespace earpoint {
namespace {

constexpr std::array<std::string_view, 5> kColumns = {"time_s", "x0", "y0", "x1", "y1"};

void check_box(const Box& box, const std::string& where) {
  const auto text = [&] {
    return fmt::format("{:g},{:g},{:g},{:g}", box.x_min, box.y_min, box.x_max, box.y_max);
  };
  if (!(box.x_min >= 0.0 && box.y_min >= 0.0 && box.x_max <= 1.0 && box.y_max <= 1.0)) {
    throw InputError(where, "the box " + text() + " leaves the picture",
                     "x0,y0,x1,y1 are fractions of its width and height, or pixels of it");
  }
  if (!(box.x_min < box.x_max && box.y_min < box.y_max)) {
    throw InputError(where, "the box " + text() + " is empty", "x0 < x1 and y0 < y1 are needed");
  }
}

/// A fraction may be a little off the picture; twice its size is no fraction.
bool is_in_pixels(const Box& box) {
  return std::max({box.x_min, box.y_min, box.x_max, box.y_max}) > 2.0;
}

Box normalised(const Box& box, const SpeakerTrack::PictureSize& picture, const std::string& where) {
  if (!picture) {
    throw InputError(where, "the box is in pixels, and there is no picture that tells their number",
                     "give fractions of its width and height, 0 to 1, or the picture");
  }
  const auto [width, height] = *picture;
  return {box.x_min / width, box.y_min / height, box.x_max / width, box.y_max / height};
}

}  // namespace

SpeakerTrack::SpeakerTrack(const Box& box, const PictureSize& picture)
    : rows_{{0.0, is_in_pixels(box) ? normalised(box, picture, "speaker box") : box}} {
  check_box(rows_.front().box, "speaker box");
}

SpeakerTrack SpeakerTrack::from_csv(const std::filesystem::path& path, const PictureSize& picture) {
  return parse_csv(read_text_file(path), path.string(), picture);
}

SpeakerTrack SpeakerTrack::parse_csv(const std::string& text, const std::string& name,
                                     const PictureSize& picture) {
  SpeakerTrack track;
  const std::vector<NumberRow> rows = parse_number_csv(text, name, kColumns);
  const auto box_of = [](const NumberRow& row) {
    return Box{row.values[1], row.values[2], row.values[3], row.values[4]};
  };
  const bool in_pixels = std::any_of(
      rows.begin(), rows.end(), [&](const NumberRow& row) { return is_in_pixels(box_of(row)); });
  for (const NumberRow& row : rows) {
    const double time_s = row.values[0];
    const std::string where = fmt::format("{}: line {}", name, row.line);
    const Box box = in_pixels ? normalised(box_of(row), picture, where) : box_of(row);
    check_box(box, where);
    if (!track.rows_.empty() && time_s <= track.rows_.back().time_s) {
      throw InputError(where, fmt::format("time {} s does not come after {} s", time_s,
                                          track.rows_.back().time_s));
    }
    track.rows_.push_back({time_s, box});
  }
  return track;
}

Box SpeakerTrack::at(double time_s) const {
  const auto after = std::upper_bound(rows_.begin(), rows_.end(), time_s,
                                      [](double t, const Row& row) { return t < row.time_s; });
  if (after == rows_.begin()) return rows_.front().box;
  const Row& before = *std::prev(after);
  if (after == rows_.end()) return before.box;
  return time_s - before.time_s <= after->time_s - time_s ? before.box : after->box;
}

}  // namespace earpoint
