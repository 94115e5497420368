#include <earpoint/study/study_plan.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

using Kind = StudyStep::Kind;
constexpr std::array<Kind, 3> kKinds{Kind::headphones, Kind::training, Kind::trial};

template <typename T>
void shuffle(std::vector<T>& items, RandomStream& random) {
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random.index(i)]);
}

StudyStep step_of(Kind kind, const StudyClip& clip, std::string_view scale, RandomStream& random) {
  StudyStep step{.kind = kind, .item = clip.id, .scale = std::string(scale), .order = {}};
  for (const StudySound& sound : clip.sounds) step.order.push_back(sound.condition);
  shuffle(step.order, random);
  return step;
}

/// Appends the training item and all clips, rated on one scale.
void append_block(const Study& study, std::string_view scale, RandomStream& random,
                  std::vector<StudyStep>& steps) {
  steps.push_back(step_of(Kind::training, study.training, scale, random));
  std::vector<const StudyClip*> clips;
  for (const StudyClip& clip : study.clips) clips.push_back(&clip);
  shuffle(clips, random);
  const auto first =
      std::ranges::find_if(clips, [](const auto* clip) { return !clip->is_control; });
  if (first != clips.end()) std::iter_swap(clips.begin(), first);
  for (const StudyClip* clip : clips) {
    steps.push_back(step_of(Kind::trial, *clip, scale, random));
  }
}

}  // namespace

std::string_view name_of(StudyStep::Kind kind) {
  switch (kind) {
    case Kind::headphones:
      return "headphones";
    case Kind::training:
      return "training";
    case Kind::trial:
      return "trial";
  }
  return "";
}

std::vector<StudyStep> plan_steps(const Study& study, int participant) {
  RandomStream random(study.seed, {1, static_cast<std::uint64_t>(participant)});
  std::vector<StudyStep> steps;
  for (std::size_t trial = 0; trial < study.headphones.size(); ++trial) {
    steps.push_back(
        {.kind = Kind::headphones, .item = fmt::format("{}", trial), .scale = {}, .order = {}});
  }
  shuffle(steps, random);
  if (study.design == StudyDesign::choice) {
    append_block(study, "", random, steps);
    return steps;
  }
  std::vector<std::string_view> scales(kStudyScales.begin(), kStudyScales.end());
  shuffle(scales, random);
  for (const std::string_view scale : scales) append_block(study, scale, random, steps);
  return steps;
}

std::string text_of(std::span<const StudyStep> steps) {
  nlohmann::json list = nlohmann::json::array();
  for (const StudyStep& step : steps) {
    list.push_back({{"kind", name_of(step.kind)},
                    {"item", step.item},
                    {"scale", step.scale},
                    {"order", step.order}});
  }
  return list.dump();
}

std::vector<StudyStep> parse_steps(const std::string& text) {
  constexpr const char* kWhere = "a participant's plan";
  const nlohmann::json document = parse_json(text, kWhere);
  std::vector<StudyStep> steps;
  for (const JsonField& item : JsonField(document, kWhere).items()) {
    const std::string kind = item.field("kind").text();
    const auto known = std::ranges::find(kKinds, kind, [](Kind k) { return name_of(k); });
    if (known == kKinds.end()) item.field("kind").fail("headphones, training or trial");
    StudyStep step{.kind = *known,
                   .item = item.field("item").text(),
                   .scale = item.field("scale").text(),
                   .order = {}};
    for (const JsonField& condition : item.field("order").items()) {
      step.order.push_back(condition.text());
    }
    steps.push_back(std::move(step));
  }
  return steps;
}

}  // namespace earpoint
