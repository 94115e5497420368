#include <earpoint/study/study_report.h>

#include "study_page.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>

namespace earpoint {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const std::optional<Estimate>& estimate) {
  if (!estimate) return nullptr;
  Json range = nullptr;
  if (estimate->range) range = Json::array({estimate->range->low, estimate->range->high});
  return {{"value", estimate->value}, {"range", range}, {"answers", estimate->clips}};
}

Json json_of(const SignVotes& votes) {
  Json detectable = nullptr;
  if (votes.detectable) detectable = *votes.detectable;
  return {{"wins", votes.wins}, {"losses", votes.losses}, {"ties", votes.ties},
          {"p", votes.p},       {"power", votes.power},   {"detectable_share", detectable}};
}

Json json_of(const StudyParticipant& participant) {
  const Participant& who = participant.participant;
  return {{"number", who.number},
          {"label", who.label},
          {"simulated", who.simulated},
          {"begun", who.begun},
          {"finished", who.finished},
          {"passed_headphones", who.passed_headphones},
          {"trials", participant.trials.size()},
          {"counted", participant.left_out.empty()},
          {"left_out", participant.left_out},
          {"comment", who.comment}};
}

Json json_of(const StudyGroup& group) {
  Json participants = Json::array();
  for (const StudyParticipant& participant : group.participants) {
    participants.push_back(json_of(participant));
  }
  Json rows = Json::array();
  for (const StudyRow& row : group.rows) {
    rows.push_back({{"condition", row.condition},
                    {"scale", row.scale},
                    {"value", json_of(row.value)},
                    {"before_screening", json_of(row.before_screening)}});
  }
  Json comparisons = Json::array();
  for (const StudyComparison& comparison : group.comparisons) {
    comparisons.push_back({{"method", comparison.method},
                           {"baseline", comparison.baseline},
                           {"scale", comparison.scale},
                           {"preference", json_of(comparison.preference)},
                           {"by_answer", json_of(comparison.by_answer)},
                           {"by_participant", json_of(comparison.by_participant)},
                           {"by_clip", json_of(comparison.by_clip)}});
  }
  return {{"name", group.name},         {"simulated", group.is_simulated},
          {"counted", group.counted},   {"answers", group.answers},
          {"rows", std::move(rows)},    {"comparisons", std::move(comparisons)},
          {"by_place", group.by_place}, {"participants", std::move(participants)}};
}

/// A cell of a CSV file.
std::string cell(const std::string& text) {
  if (text.find_first_of(",;\"\n\r\t") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string estimate_text(const Study& study, const std::optional<Estimate>& estimate) {
  if (!estimate) return "none";
  const bool is_share = study.design == StudyDesign::choice;
  const double factor = is_share ? 100.0 : 1.0;
  std::string text = fmt::format("{:5.1f}{}", factor * estimate->value, is_share ? " %" : "");
  if (!estimate->range) return text;
  return text + fmt::format("  [{:.1f}, {:.1f}]", factor * estimate->range->low,
                            factor * estimate->range->high);
}

std::string row_text(const Study& study, const StudyRow& row) {
  const std::string value = estimate_text(study, row.value);
  const std::string before = estimate_text(study, row.before_screening);
  return fmt::format("  {:<16}{}{}\n", row.condition, value,
                     before == value ? "" : "   before screening " + before);
}

std::string votes_text(const SignVotes& votes) {
  return fmt::format("{}:{} p={:.2g}", votes.wins, votes.losses, votes.p);
}

std::string comparison_text(const StudyComparison& comparison) {
  std::string text =
      fmt::format("  {} against {}: answers {}, participants {}, clips {}\n", comparison.method,
                  comparison.baseline, votes_text(comparison.by_answer),
                  votes_text(comparison.by_participant), votes_text(comparison.by_clip));
  const auto power = [](const SignVotes& votes) {
    return votes.detectable ? fmt::format("{:.0f} %", 100.0 * *votes.detectable)
                            : std::string("none");
  };
  text += fmt::format(
      "    smallest preference found with a power of 80 %: answers {}, participants {}, clips {}\n",
      power(comparison.by_answer), power(comparison.by_participant), power(comparison.by_clip));
  return text;
}

std::string group_text(const Study& study, const StudyGroup& group) {
  std::string text = fmt::format("\n{}{}: {} of {} participants count, {} answers\n",
                                 group.is_simulated ? "NOT PEOPLE, " : "", group.name,
                                 group.counted, group.participants.size(), group.answers);
  for (const StudyParticipant& participant : group.participants) {
    if (participant.left_out.empty()) continue;
    text += fmt::format("  left out: participant {} {}\n", participant.participant.number,
                        participant.left_out);
  }
  std::string scale;
  for (const StudyRow& row : group.rows) {
    if (row.scale != scale) text += fmt::format(" {}\n", row.scale);
    scale = row.scale;
    text += row_text(study, row);
    const auto last_of_scale = [&] {
      const auto next = &row + 1;
      return next == group.rows.data() + group.rows.size() || next->scale != scale;
    };
    if (!last_of_scale()) continue;
    for (const StudyComparison& comparison : group.comparisons) {
      if (comparison.scale == scale) text += comparison_text(comparison);
    }
  }
  return text;
}

}  // namespace

std::string text_of(const Study& study, std::span<const StudyGroup> groups) {
  std::string text = fmt::format(
      "{}: {} clips of {} ({}), {}\n", study.title,
      std::ranges::count_if(study.clips, [](const StudyClip& clip) { return !clip.is_control; }),
      study.data, study.split,
      study.design == StudyDesign::choice ? "share of choices as the closest"
                                          : "mean ratings from 0 to 100");
  if (groups.empty()) text += "Nobody has taken part yet.\n";
  for (const StudyGroup& group : groups) text += group_text(study, group);
  return text;
}

std::string json_of(const Study& study, std::span<const StudyGroup> groups) {
  Json methods = Json::array();
  for (const StudyMethod& method : study.methods) {
    methods.push_back(
        {{"name", method.name}, {"what", method.what}, {"baseline", method.is_baseline}});
  }
  Json list = Json::array();
  for (const StudyGroup& group : groups) list.push_back(json_of(group));
  const Json document{
      {"title", study.title},        {"design", name_of(study.design)},
      {"data", study.data},          {"split", study.split},
      {"seed", study.seed},          {"loudness", study.loudness_matched ? "matched" : "kept"},
      {"clips", study.clips.size()}, {"methods", std::move(methods)},
      {"power_share", kPowerShare},  {"groups", std::move(list)}};
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string answers_csv(const Study& study, std::span<const StudyGroup> groups) {
  std::string text =
      "participant,label,simulated,counted,clip,pair,control,scale,condition,place,value,revision,"
      "seconds,received\n";
  for (const StudyGroup& group : groups) {
    for (const StudyParticipant& participant : group.participants) {
      const Participant& who = participant.participant;
      for (const StudyTrial& trial : participant.trials) {
        const StudyClip& clip = study.clips[trial.clip];
        for (std::size_t place = 0; place < trial.order.size(); ++place) {
          text += fmt::format("{},{},{},{},{},{},{},{},{},{},{:g},{},{:g},{}\n", who.number,
                              cell(who.label), cell(who.simulated),
                              participant.left_out.empty() ? 1 : 0, cell(clip.id), cell(clip.pair),
                              clip.is_control ? 1 : 0, trial.scale, cell(trial.order[place]),
                              place + 1, trial.values.at(trial.order[place]), trial.answer.revision,
                              trial.answer.seconds, trial.answer.received);
        }
      }
    }
  }
  return text;
}

void write_study_report(const std::filesystem::path& folder, const Study& study,
                        std::span<const StudyGroup> groups) {
  create_folder(folder);
  write_file(folder / "index.html", study_page(study, groups));
  write_file(folder / "answers.csv", answers_csv(study, groups));
  write_file(folder / "results.json", json_of(study, groups));
}

}  // namespace earpoint
