#include <earpoint/generate/generation_summary.h>

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include <earpoint/error.h>

namespace earpoint {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kHistogramStep_s = 0.1;

/// @throws InputError if the JSON has another form than json_of() writes
template <typename Read>
ConversationReport read_or_explain(const std::string& where, Read read) {
  try {
    return read();
  } catch (const nlohmann::json::exception& error) {
    throw InputError(where, std::string("is damaged: ") + error.what(),
                     "delete its folder and start the simulation again");
  }
}

}  // namespace

std::string json_of(const ConversationReport& report) {
  Json json;
  json["voices"] = report.voices;
  json["speech_s"] = report.speech_s;
  json["escape_fraction"] = report.escape_fraction;
  json["reverberation_s"] = report.reverberation_s ? Json(*report.reverberation_s) : Json();
  json["viewpoints"] = report.viewpoints;
  json["hidden"] = report.hidden;
  return json.dump(1) + "\n";
}

ConversationReport parse_conversation_report(std::string_view json, const std::string& where) {
  return read_or_explain(where, [&] {
    const Json document = Json::parse(json);
    ConversationReport report;
    report.voices = document.at("voices").get<std::vector<std::string>>();
    report.speech_s = document.at("speech_s").get<std::vector<double>>();
    report.escape_fraction = document.at("escape_fraction").get<std::vector<double>>();
    const Json& reverberation = document.at("reverberation_s");
    if (!reverberation.is_null()) report.reverberation_s = reverberation.get<double>();
    report.viewpoints = document.at("viewpoints").get<int>();
    report.hidden = document.at("hidden").get<int>();
    return report;
  });
}

void GenerationSummary::add(const ConversationReport& report) {
  const auto speakers = static_cast<int>(report.speech_s.size());
  ++conversations;
  viewpoints += report.viewpoints;
  hidden += report.hidden;
  voices.insert(report.voices.begin(), report.voices.end());
  for (const double speech_s : report.speech_s) hours += report.viewpoints * speech_s / 3600.0;
  for (const double escaped : report.escape_fraction) {
    most_escape_fraction = std::max(most_escape_fraction, escaped);
    mean_escape_fraction += (escaped - mean_escape_fraction) / ++traces;
  }
  responses += speakers * report.viewpoints;
  if (!report.reverberation_s) {
    ++without_reverberation;
    return;
  }
  const auto step = static_cast<std::size_t>(*report.reverberation_s / kHistogramStep_s);
  ++reverberation_histogram[std::min(step, reverberation_histogram.size() - 1)];
}

std::string json_of(const GenerationSummary& summary) {
  Json json;
  json["hours"] = summary.hours;
  json["scenes"] = summary.scenes;
  json["conversations"] = summary.conversations;
  json["viewpoints"] = summary.viewpoints;
  json["responses"] = summary.responses;
  json["hidden"] = summary.hidden;
  json["voices"] = summary.voices.size();
  json["reverberation_step_s"] = kHistogramStep_s;
  json["reverberation_histogram"] = summary.reverberation_histogram;
  json["without_reverberation"] = summary.without_reverberation;
  json["mean_escape_fraction"] = summary.mean_escape_fraction;
  json["most_escape_fraction"] = summary.most_escape_fraction;
  json["missing_conversations"] = summary.missing;
  Json run;
  run["simulated_conversations"] = summary.simulated;
  run["wall_s"] = summary.wall_s;
  run["core_seconds"] = Json::object();
  for (int stage = 0; stage < kStages; ++stage) {
    run["core_seconds"][std::string(name_of(static_cast<Stage>(stage)))] =
        summary.seconds.seconds(static_cast<Stage>(stage));
  }
  json["run"] = std::move(run);
  return json.dump(2) + "\n";
}

}  // namespace earpoint
