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
                     "x0,y0,x1,y1 are fractions of its width and height, 0 to 1");
  }
  if (!(box.x_min < box.x_max && box.y_min < box.y_max)) {
    throw InputError(where, "the box " + text() + " is empty", "x0 < x1 and y0 < y1 are needed");
  }
}

}  // namespace

SpeakerTrack::SpeakerTrack(const Box& box) : rows_{{0.0, box}} { check_box(box, "speaker box"); }

SpeakerTrack SpeakerTrack::from_csv(const std::filesystem::path& path) {
  return parse_csv(read_text_file(path), path.string());
}

SpeakerTrack SpeakerTrack::parse_csv(const std::string& text, const std::string& name) {
  SpeakerTrack track;
  for (const NumberRow& row : parse_number_csv(text, name, kColumns)) {
    const auto& v = row.values;
    const std::string where = fmt::format("{}: line {}", name, row.line);
    const Box box{v[1], v[2], v[3], v[4]};
    check_box(box, where);
    if (!track.rows_.empty() && v[0] <= track.rows_.back().time_s) {
      throw InputError(where, fmt::format("time {} s does not come after {} s", v[0],
                                          track.rows_.back().time_s));
    }
    track.rows_.push_back({v[0], box});
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
