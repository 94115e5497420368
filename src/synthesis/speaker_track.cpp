#include <earpoint/synthesis/speaker_track.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/csv.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::array<std::string_view, 5> kColumns = {"time_s", "x0", "y0", "x1", "y1"};
constexpr std::array<std::string_view, 8> kPeopleColumns = {"time_s", "track", "x0",       "y0",
                                                            "x1",     "y1",    "speaking", "voice"};

void check_box(const Box& box, const std::string& where) {
  const auto text = [&] {
    return fmt::format("{:g},{:g},{:g},{:g}", box.x_min, box.y_min, box.x_max, box.y_max);
  };
  if (!(box.x_min >= 0.0 && box.y_min >= 0.0 && box.x_max <= 1.0 && box.y_max <= 1.0)) {
    throw InputError(where, "the box " + text() + " extends beyond the picture",
                     "x0,y0,x1,y1 are fractions of its width and height, or pixels of it");
  }
  if (!(box.x_min < box.x_max && box.y_min < box.y_max)) {
    throw InputError(where, "the box " + text() + " is empty", "x0 < x1 and y0 < y1 are needed");
  }
}

/// Fractions may lie a little outside the picture, but not beyond twice its size.
bool is_in_pixels(const Box& box) {
  return std::max({box.x_min, box.y_min, box.x_max, box.y_max}) > 2.0;
}

Box normalised(const Box& box, const SpeakerTrack::PictureSize& picture, const std::string& where) {
  if (!picture) {
    throw InputError(where, "the box is in pixels, but the size of the picture is not known",
                     "give fractions of its width and height, 0 to 1, or the picture");
  }
  const auto [width, height] = *picture;
  return {box.x_min / width, box.y_min / height, box.x_max / width, box.y_max / height};
}

/// The boxes of a file, checked. @param first  the column of x0
std::vector<Box> boxes_of(std::span<const NumberRow> rows, std::size_t first,
                          const std::string& name, const SpeakerTrack::PictureSize& picture) {
  std::vector<Box> boxes;
  for (const NumberRow& row : rows) {
    boxes.push_back({.x_min = row.values[first],
                     .y_min = row.values[first + 1],
                     .x_max = row.values[first + 2],
                     .y_max = row.values[first + 3]});
  }
  const bool in_pixels = std::ranges::any_of(boxes, is_in_pixels);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string where = fmt::format("{}: line {}", name, rows[i].line);
    if (in_pixels) boxes[i] = normalised(boxes[i], picture, where);
    check_box(boxes[i], where);
  }
  return boxes;
}

void check_time(const NumberRow& row, double before_s, const std::string& name) {
  const double time_s = row.values[0];
  if (time_s > before_s) return;
  throw InputError(fmt::format("{}: line {}", name, row.line),
                   fmt::format("time {} s does not come after {} s", time_s, before_s));
}

/// Whether the header is that of a table of people, with several rows for one time.
bool tells_of_people(std::string_view text, const std::string& name) {
  text = without_byte_order_mark(text, name);
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    if (line.find_first_not_of(" \t\r") != std::string_view::npos && !line.starts_with('#')) {
      return line.find("track") != std::string_view::npos;
    }
    text.remove_prefix(std::min(text.size(), line.size() + 1));
  }
  return false;
}

/// Chooses the speaker among the rows of one time.
class Choice {
 public:
  /// @param people  rows of one time, in the order of kPeopleColumns
  std::optional<std::size_t> of(std::span<const NumberRow> people) {
    std::size_t best = 0;
    double sum = 0.0;
    for (std::size_t i = 0; i < people.size(); ++i) {
      sum += people[i].values[kSpeaking];
      if (people[i].values[kSpeaking] > people[best].values[kSpeaking]) best = i;
    }
    const double voice = people.front().values[kVoice];
    if (voice >= 0.5) {
      const bool is_outside = voice - sum > people[best].values[kSpeaking];
      speaker_ = is_outside ? std::nullopt : std::optional(people[best].values[kTrack]);
    }
    for (std::size_t i = 0; i < people.size(); ++i) {
      if (speaker_ == people[i].values[kTrack]) return i;
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t kTrack = 1;
  static constexpr std::size_t kSpeaking = 6;
  static constexpr std::size_t kVoice = 7;
  std::optional<double> speaker_;
};

std::vector<SpeakerTrack::Row> rows_of_people(const std::string& text, const std::string& name,
                                              const SpeakerTrack::PictureSize& picture) {
  const std::vector<NumberRow> rows = parse_number_csv(text, name, kPeopleColumns);
  const std::vector<Box> boxes = boxes_of(rows, 2, name, picture);
  std::vector<SpeakerTrack::Row> chosen;
  Choice choice;
  for (std::size_t first = 0; first < rows.size();) {
    const double time_s = rows[first].values[0];
    std::size_t last = first;
    while (last < rows.size() && rows[last].values[0] == time_s) ++last;
    const auto speaker = choice.of(std::span(rows).subspan(first, last - first));
    chosen.push_back({time_s, speaker ? std::optional(boxes[first + *speaker]) : std::nullopt});
    if (last < rows.size()) check_time(rows[last], time_s, name);
    first = last;
  }
  return chosen;
}

}  // namespace

SpeakerTrack::SpeakerTrack(const Box& box, const PictureSize& picture)
    : rows_{{0.0, is_in_pixels(box) ? normalised(box, picture, "speaker box") : box}} {
  check_box(*rows_.front().box, "speaker box");
}

SpeakerTrack::SpeakerTrack(std::vector<Row> rows) : rows_(std::move(rows)) {
  EARPOINT_CHECK(!rows_.empty());
}

SpeakerTrack SpeakerTrack::from_csv(const std::filesystem::path& path, const PictureSize& picture) {
  return parse_csv(read_text_file(path), path.string(), picture);
}

SpeakerTrack SpeakerTrack::parse_csv(const std::string& text, const std::string& name,
                                     const PictureSize& picture) {
  if (tells_of_people(text, name)) return SpeakerTrack(rows_of_people(text, name, picture));
  const std::vector<NumberRow> rows = parse_number_csv(text, name, kColumns);
  const std::vector<Box> boxes = boxes_of(rows, 1, name, picture);
  std::vector<Row> track;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i > 0) check_time(rows[i], rows[i - 1].values[0], name);
    track.push_back({rows[i].values[0], boxes[i]});
  }
  return SpeakerTrack(std::move(track));
}

std::optional<Box> SpeakerTrack::at(double time_s) const {
  const auto after = std::upper_bound(rows_.begin(), rows_.end(), time_s,
                                      [](double t, const Row& row) { return t < row.time_s; });
  if (after == rows_.begin()) return rows_.front().box;
  const Row& before = *std::prev(after);
  if (after == rows_.end()) return before.box;
  return time_s - before.time_s <= after->time_s - time_s ? before.box : after->box;
}

std::optional<SpeakerTrack> SpeakerTrack::held() const {
  std::vector<Row> kept;
  std::ranges::copy_if(rows_, std::back_inserter(kept),
                       [](const Row& row) { return row.box.has_value(); });
  return kept.empty() ? std::nullopt : std::optional(SpeakerTrack(std::move(kept)));
}

}  // namespace earpoint
