#include "simulate_report.h"

#include <fmt/format.h>

#include <earpoint/core/progress.h>

namespace earpoint {

std::string simulation_report(const GenerationSummary& summary) {
  std::string text;
  for (const auto& [split, scenes] : summary.scenes) {
    text += fmt::format("{:<12} {} scene{}\n", split, scenes, scenes == 1 ? "" : "s");
  }
  text +=
      fmt::format("{} conversations, {} viewpoints, {} responses ({} of a speaker out of sight)\n",
                  summary.conversations, summary.viewpoints, summary.responses, summary.hidden);
  text += fmt::format("{:.2f} h of sound, {} voices\n", summary.hours, summary.voices.size());
  text += "reverberation time, conversations per 0.1 s:";
  for (const int count : summary.reverberation_histogram) text += fmt::format(" {}", count);
  text += fmt::format("\nescape fraction {:.2g} on average, {:.2g} at most\n",
                      summary.mean_escape_fraction, summary.most_escape_fraction);
  if (summary.missing > 0)
    text += fmt::format("{} conversations are still missing\n", summary.missing);
  if (summary.simulated == 0) return text;
  text += fmt::format("made {} conversations in {}; core-seconds each:", summary.simulated,
                      format_duration(summary.wall_s));
  for (int stage = 0; stage < kStages; ++stage) {
    const auto which = static_cast<Stage>(stage);
    text += fmt::format(" {} {:.2f}", name_of(which),
                        summary.seconds.seconds(which) / summary.simulated);
  }
  return text + "\n";
}

}  // namespace earpoint
