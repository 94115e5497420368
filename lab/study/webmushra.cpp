#include <earpoint/study/webmushra.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/evaluate/report_html.h>

namespace earpoint {
namespace {

/// A JSON text is a YAML text.
std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

class ConfigurationWriter {
 public:
  ConfigurationWriter(const Study& study, const std::string& place)
      : study_(study), place_(place) {}

  [[nodiscard]] std::string write() const {
    std::string text = fmt::format(
        "testname: {}\ntestId: {}\nbufferSize: 2048\nstopOnErrors: true\n"
        "showButtonPreviousPage: true\nremoteService: service/write.php\npages:\n",
        quoted(study_.title), quoted(fmt::format("earpoint-{}", study_.seed)));
    text += fmt::format(
        "  - type: volume\n    id: volume\n    name: Volume\n    content: {}\n    stimulus: {}\n"
        "    defaultVolume: 0.5\n",
        quoted("Put on headphones and set a comfortable volume."),
        quoted(path(study_.training.reference)));
    if (study_.design == StudyDesign::choice) {
      text += pages("");
    } else {
      for (const auto scale : kStudyScales) text += pages(std::string(scale));
    }
    return text +
           "  - type: finish\n    name: Thank you\n    content: \"\"\n    showResults: false\n"
           "    writeResults: true\n";
  }

 private:
  [[nodiscard]] std::string path(const std::string& file) const { return place_ + "/" + file; }

  /// The training page, and all clips in random order.
  [[nodiscard]] std::string pages(const std::string& scale) const {
    std::string text = page(study_.training, scale, "  ") + "  -\n    - random\n";
    for (const StudyClip& clip : study_.clips) {
      if (!clip.is_control) text += page(clip, scale, "    ");
    }
    return text;
  }

  [[nodiscard]] std::string page(const StudyClip& clip, const std::string& scale,
                                 const std::string& indent) const {
    const bool is_choice = study_.design == StudyDesign::choice;
    std::string question = "Which sound is closest to the reference?";
    if (scale == kStudyScales[0])
      question = "How close is the position of the voice to the reference?";
    if (scale == kStudyScales[1]) question = "How close is the timbre to the reference?";
    const std::string content =
        fmt::format("<p>{}</p><img src=\"{}\" alt=\"What the listener sees\" height=\"256\">",
                    question, escaped(path(clip.picture)));
    std::string text =
        fmt::format("{}- type: {}\n", indent, is_choice ? "paired_comparison" : "mushra");
    const auto line = [&](const std::string& key, const std::string& value) {
      text += fmt::format("{}  {}: {}\n", indent, key, value);
    };
    line("id", quoted(scale.empty() ? clip.id : clip.id + "-" + scale));
    line("name", quoted(scale.empty() ? "Closest" : scale));
    line("content", quoted(content));
    line("showWaveform", "false");
    line("enableLooping", "true");
    line("reference", quoted(path(clip.reference)));
    if (!is_choice) {
      line("strict", "false");
      line("createAnchor35", "false");
      line("createAnchor70", "false");
    }
    text += indent + "  stimuli:\n";
    for (const StudySound& sound : clip.sounds) {
      if (sound.condition == kTruthCondition) continue;
      text +=
          fmt::format("{}    {}: {}\n", indent, quoted(sound.condition), quoted(path(sound.file)));
    }
    return text;
  }

  const Study& study_;
  const std::string& place_;
};

}  // namespace

std::string webmushra_yaml(const Study& study, const std::string& place) {
  return ConfigurationWriter(study, place).write();
}

}  // namespace earpoint
