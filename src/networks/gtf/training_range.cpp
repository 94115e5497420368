#include <earpoint/gtf/training_range.h>

#include <array>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

struct Field {
  const char* key;
  double GtfTrainingRange::*value;
  double most;
};

constexpr std::array<Field, 6> kFields{
    {{"farthest_move_m", &GtfTrainingRange::farthest_move_m, 1000.0},
     {"highest_move_m", &GtfTrainingRange::highest_move_m, 1000.0},
     {"farthest_speaker_m", &GtfTrainingRange::farthest_speaker_m, 1000.0},
     {"highest_speaker_m", &GtfTrainingRange::highest_speaker_m, 1000.0},
     {"level_move_m", &GtfTrainingRange::level_move_m, 1000.0},
     {"level_head_deg", &GtfTrainingRange::level_head_deg, 180.0}}};

}  // namespace

std::string to_json(const GtfTrainingRange& range) {
  nlohmann::json json;
  for (const Field& field : kFields) json[field.key] = range.*field.value;
  return json.dump();
}

GtfTrainingRange gtf_training_range_from_json(std::string_view text, std::string_view where,
                                              GtfTrainingRange range) {
  const nlohmann::json json = parse_strict_json(text, where, 1);
  JsonObjectReader reader(json, where);
  for (const Field& field : kFields) {
    if (!reader.has(field.key)) continue;
    const double value = reader.number(field.key);
    if (!(value > 0.0 && value <= field.most)) {
      throw InputError(where, fmt::format("'{}': expected more than 0 and at most {:g}, found {:g}",
                                          field.key, field.most, value));
    }
    range.*field.value = value;
  }
  reader.expect_nothing_else();
  return range;
}

}  // namespace earpoint
