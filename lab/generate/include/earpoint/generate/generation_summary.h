#pragma once

#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/generate/stage_clock.h>

namespace earpoint {

/// What is known of one finished conversation, beside its metadata.
struct ConversationReport {
  std::vector<std::string> voices;      ///< of its speakers
  std::vector<double> speech_s;         ///< how long each speaks
  std::vector<double> escape_fraction;  ///< by speaker
  std::optional<double> reverberation_s;
  int viewpoints = 0;
  int hidden = 0;  ///< pairs of a viewpoint and a speaker who is out of its sight
};

/// @return as JSON: parse_conversation_report gives it back
std::string json_of(const ConversationReport& report);
/// @throws InputError naming the field that is missing or malformed
ConversationReport parse_conversation_report(std::string_view json, const std::string& where);

/// What a data set holds, and what this run of the simulator took.
struct GenerationSummary {
  std::map<std::string, int> scenes;  ///< by split
  int conversations = 0;
  int viewpoints = 0;
  int responses = 0;  ///< impulse responses: pairs of a viewpoint and a speaker
  int hidden = 0;     ///< of these, where the speaker is out of sight
  std::set<std::string> voices;
  double hours = 0.0;  ///< of sound: every speaker's speech as every viewpoint of it hears it
  /// Conversations by T20 in steps of 0.1 s; the last step holds all longer ones.
  std::array<int, 16> reverberation_histogram{};
  int without_reverberation = 0;  ///< whose response does not decay far enough
  int traces = 0;                 ///< of a speaker's sound
  double mean_escape_fraction = 0.0;
  double most_escape_fraction = 0.0;

  int simulated = 0;    ///< conversations made by this run
  int missing = 0;      ///< conversations of the order that are not there yet
  StageClock seconds;   ///< of processor time, by stage, of this run
  double wall_s = 0.0;  ///< of this run

  /// Counts a conversation; `scenes` is left to the caller.
  void add(const ConversationReport& report);
};

/// @return the summary as JSON
std::string json_of(const GenerationSummary& summary);

}  // namespace earpoint
