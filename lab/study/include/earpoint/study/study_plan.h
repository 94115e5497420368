#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/study/study.h>

namespace earpoint {

/// One page that a participant answers.
struct StudyStep {
  enum class Kind {
    headphones,  ///< the item is the trial's number, from 0
    training,    ///< the item is the training clip; its answer does not count
    trial,       ///< the item is a clip
  };
  Kind kind = Kind::trial;
  std::string item;
  std::string scale;               ///< one of kStudyScales in the design mushra, else empty
  std::vector<std::string> order;  ///< conditions, as the participant sees them

  friend bool operator==(const StudyStep&, const StudyStep&) = default;
};

/// @return "headphones", "training" or "trial"
[[nodiscard]] std::string_view name_of(StudyStep::Kind kind);

/// The steps of a participant: the headphone check, the training item and all clips, in an order
/// that the study's seed and the participant's number draw; sounds likewise. In the design mushra
/// all clips are rated on one scale, and then on the other, training items first; which scale comes
/// first is drawn. No study begins with a control.
[[nodiscard]] std::vector<StudyStep> plan_steps(const Study& study, int participant);

/// As it is stored, JSON.
[[nodiscard]] std::string text_of(std::span<const StudyStep> steps);
/// @throws InputError if the text is no plan
[[nodiscard]] std::vector<StudyStep> parse_steps(const std::string& text);

}  // namespace earpoint
