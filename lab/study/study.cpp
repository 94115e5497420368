#include <earpoint/study/study.h>

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "earpoint-study-1";

Json json_of(const StudyClip& clip) {
  Json sounds = Json::array();
  for (const StudySound& sound : clip.sounds) {
    sounds.push_back({{"condition", sound.condition},
                      {"file", sound.file},
                      {"gain_db", sound.gain_db},
                      {"mag", sound.mag}});
  }
  return {{"id", clip.id},
          {"pair", clip.pair},
          {"scene", clip.scene},
          {"picture", clip.picture},
          {"reference", clip.reference},
          {"control", clip.is_control},
          {"sounds", std::move(sounds)}};
}

/// Reads the parts of a study, whose files lie in one folder.
class StudyParser {
 public:
  explicit StudyParser(const fs::path& folder) : folder_(folder) {}

  [[nodiscard]] StudyClip clip(const JsonField& json) const {
    json.expect_only({"id", "pair", "scene", "picture", "reference", "control", "sounds"});
    StudyClip clip{.id = json.field("id").text(),
                   .pair = json.field("pair").text(),
                   .scene = json.field("scene").text(),
                   .picture = file(json.field("picture")),
                   .reference = file(json.field("reference")),
                   .sounds = {},
                   .is_control = json.field("control").boolean()};
    for (const JsonField& item : json.field("sounds").items()) {
      item.expect_only({"condition", "file", "gain_db", "mag"});
      clip.sounds.push_back({.condition = item.field("condition").text(),
                             .file = file(item.field("file")),
                             .gain_db = item.field("gain_db").number(),
                             .mag = item.field("mag").number()});
    }
    if (clip.sounds.size() < 2) json.field("sounds").fail("two sounds or more");
    return clip;
  }

  [[nodiscard]] HeadphoneTrial headphone_trial(const JsonField& json) const {
    json.expect_only({"file", "quietest"});
    const int quietest = json.field("quietest").integer();
    if (quietest < 0 || quietest > 2) json.field("quietest").fail("0, 1 or 2");
    return {file(json.field("file")), quietest};
  }

 private:
  [[nodiscard]] std::string file(const JsonField& field) const {
    std::string name = field.text();
    const fs::path path = fs::path(name).lexically_normal();
    if (path.is_absolute() || path.empty() || *path.begin() == "..") {
      field.fail("a file in the study's folder");
    }
    if (!fs::is_regular_file(folder_ / path)) {
      throw InputError((folder_ / path).string(), "is not there",
                       "make the study again (earpoint study make)");
    }
    return name;
  }

  const fs::path& folder_;
};

}  // namespace

std::string_view name_of(StudyDesign design) {
  return design == StudyDesign::choice ? "choice" : "mushra";
}

StudyDesign study_design_named(std::string_view name) {
  for (const StudyDesign design : {StudyDesign::choice, StudyDesign::mushra}) {
    if (name == name_of(design)) return design;
  }
  throw InputError("design", fmt::format("expected choice or mushra, found '{}'", name));
}

const StudyClip* Study::find_clip(std::string_view id) const {
  if (training.id == id) return &training;
  const auto clip = std::ranges::find(clips, id, &StudyClip::id);
  return clip == clips.end() ? nullptr : &*clip;
}

std::string text_of(const Study& study) {
  Json methods = Json::array();
  for (const StudyMethod& method : study.methods) {
    methods.push_back(
        {{"name", method.name}, {"what", method.what}, {"baseline", method.is_baseline}});
  }
  Json clips = Json::array();
  for (const StudyClip& clip : study.clips) clips.push_back(json_of(clip));
  Json headphones = Json::array();
  for (const HeadphoneTrial& trial : study.headphones) {
    headphones.push_back({{"file", trial.file}, {"quietest", trial.quietest}});
  }
  const Json document{{"format", kFormat},
                      {"design", name_of(study.design)},
                      {"title", study.title},
                      {"data", study.data},
                      {"split", study.split},
                      {"pairs", study.pairs},
                      {"seed", study.seed},
                      {"duration_s", study.duration_s},
                      {"loudness", study.loudness_matched ? "matched" : "kept"},
                      {"methods", std::move(methods)},
                      {"clips", std::move(clips)},
                      {"training", json_of(study.training)},
                      {"headphones", std::move(headphones)}};
  return document.dump(1) + "\n";
}

Study read_study(const fs::path& folder) {
  const fs::path path = folder / "study.json";
  const nlohmann::json document = read_json(path);
  const JsonField json(document, path.string());
  if (json.field("format").text() != kFormat) {
    json.field("format").fail(fmt::format("\"{}\"", kFormat));
  }
  json.expect_only({"format", "design", "title", "data", "split", "pairs", "seed", "duration_s",
                    "loudness", "methods", "clips", "training", "headphones"});
  const std::string loudness = json.field("loudness").text();
  if (loudness != "matched" && loudness != "kept") {
    json.field("loudness").fail("\"matched\" or \"kept\"");
  }
  const StudyParser parser(folder);
  Study study;
  study.design = study_design_named(json.field("design").text());
  study.title = json.field("title").text();
  study.data = json.field("data").text();
  study.split = json.field("split").text();
  study.pairs = json.field("pairs").text();
  study.seed = static_cast<std::uint64_t>(json.field("seed").number());
  study.duration_s = json.field("duration_s").number();
  study.loudness_matched = loudness == "matched";
  for (const JsonField& item : json.field("methods").items()) {
    item.expect_only({"name", "what", "baseline"});
    study.methods.push_back({.name = item.field("name").text(),
                             .what = item.field("what").text(),
                             .is_baseline = item.field("baseline").boolean()});
  }
  for (const JsonField& item : json.field("clips").items()) {
    study.clips.push_back(parser.clip(item));
  }
  study.training = parser.clip(json.field("training"));
  for (const JsonField& item : json.field("headphones").items()) {
    study.headphones.push_back(parser.headphone_trial(item));
  }
  if (study.methods.size() < 2) json.field("methods").fail("two methods or more");
  if (study.clips.empty()) json.field("clips").fail("a clip or more");
  if (study.headphones.size() != kHeadphoneTrials) {
    json.field("headphones").fail(fmt::format("{} trials", kHeadphoneTrials));
  }
  return study;
}

}  // namespace earpoint
