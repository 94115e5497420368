// The plugin as DPF wants it: names, parameters, and the audio thread's call.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <DistrhoPlugin.hpp>
#include <DistrhoPluginUtils.hpp>

#include <earpoint/version.h>

#include "live_renderer.h"
#include "model_search.h"
#include "parameters.h"

namespace earpoint::plugin {
namespace {

/// The models by which this process offers the plugin: searched once, so that their numbers stay.
const std::vector<StreamingModel>& models() {
  static const std::vector<StreamingModel> found =
      find_streaming_models(DISTRHO::getBinaryFilename());
  return found;
}

/// Gives a parameter's values labels: from 0 on, one each.
void label(DISTRHO::Parameter& parameter, const std::vector<const char*>& labels) {
  auto* const values = new DISTRHO::ParameterEnumerationValue[labels.size()];  // DPF deletes it
  for (std::size_t i = 0; i < labels.size(); ++i) {
    values[i].value = static_cast<float>(i);
    values[i].label = labels[i];
  }
  parameter.enumValues.count = static_cast<std::uint8_t>(labels.size());
  parameter.enumValues.values = values;
}

void describe_plain(const ParameterDescription& plain, DISTRHO::Parameter& parameter) {
  parameter.symbol = plain.symbol;
  parameter.name = plain.name;
  parameter.unit = plain.unit;
  parameter.description = plain.comment;
  parameter.ranges = {plain.standard, plain.least, plain.most};
  if (plain.is_switch)
    parameter.hints |= DISTRHO::kParameterIsBoolean | DISTRHO::kParameterIsInteger;
}

void describe_model(DISTRHO::Parameter& parameter) {
  parameter.hints |= DISTRHO::kParameterIsInteger;
  parameter.symbol = "model";
  parameter.name = "Model";
  parameter.description = "The network; a number without a name means the first";
  parameter.ranges = {0.0F, 0.0F, static_cast<float>(kMostModels - 1)};
  std::vector<const char*> labels;
  for (const StreamingModel& model : models()) labels.push_back(model.name.c_str());
  label(parameter, labels);
}

void describe_status(DISTRHO::Parameter& parameter) {
  parameter.hints |= DISTRHO::kParameterIsInteger;
  parameter.symbol = "status";
  parameter.name = "Status";
  parameter.description = "Whether sound is rendered, or why it passes unchanged";
  parameter.ranges = {0.0F, 0.0F, 2.0F};
  label(parameter, {"renders", "sample rate is not supported", "no model is found"});
  parameter.enumValues.restrictedMode = true;
}

class EarpointPlugin : public DISTRHO::Plugin {
 public:
  EarpointPlugin() : Plugin(kParameterCount, 0, 0) {
    for (const ParameterDescription& plain : plain_parameters()) values_[plain.id] = plain.standard;
  }

 protected:
  const char* getLabel() const override { return "earpoint"; }
  const char* getDescription() const override {
    return "Binaural sound at another position in the room, live";
  }
  const char* getMaker() const override { return "Earpoint"; }
  const char* getLicense() const override { return "Apache-2.0"; }
  std::uint32_t getVersion() const override {
    return d_version(EARPOINT_VERSION_MAJOR, EARPOINT_VERSION_MINOR, EARPOINT_VERSION_PATCH);
  }
  std::int64_t getUniqueId() const override { return d_cconst('E', 'a', 'r', 'p'); }

  void initAudioPort(bool input, std::uint32_t index, DISTRHO::AudioPort& port) override {
    port.groupId = DISTRHO::kPortGroupStereo;
    Plugin::initAudioPort(input, index, port);
  }

  void initParameter(std::uint32_t index, DISTRHO::Parameter& parameter) override {
    if (index == kBypass) {
      parameter.initDesignation(DISTRHO::kParameterDesignationBypass);
      return;
    }
    parameter.hints =
        index < kStatus ? DISTRHO::kParameterIsAutomatable : DISTRHO::kParameterIsOutput;
    if (index == kModel) return describe_model(parameter);
    if (index == kStatus) return describe_status(parameter);
    const auto plain =
        std::ranges::find(plain_parameters(), ParameterId{index}, &ParameterDescription::id);
    describe_plain(*plain, parameter);
  }

  float getParameterValue(std::uint32_t index) const override {
    return values_[index].load(std::memory_order_relaxed);
  }
  void setParameterValue(std::uint32_t index, float value) override {
    if (index >= kStatus || !std::isfinite(value)) return;
    values_[index].store(within_range(ParameterId{index}, value), std::memory_order_relaxed);
  }

  void activate() override {
    if (renderer_ && prepared_hz_ == getSampleRate()) {
      renderer_->reset();
    } else {
      prepare(getSampleRate());
    }
  }
  void run(const float** inputs, float** outputs, std::uint32_t frames) override {
    if (!renderer_) return;
    renderer_->process(settings(), inputs, outputs, frames);
    if (const auto speaker = renderer_->speaker_m()) {
      const Vector3& mouth = *speaker;
      values_[kLocatedX].store(static_cast<float>(mouth.x), std::memory_order_relaxed);
      values_[kLocatedY].store(static_cast<float>(mouth.y), std::memory_order_relaxed);
      values_[kLocatedZ].store(static_cast<float>(mouth.z), std::memory_order_relaxed);
    }
  }

 private:
  /// Reads models and allocates: hosts do not activate on the audio thread.
  void prepare(double sample_rate_hz) {
    renderer_ = std::make_unique<LiveRenderer>(models(), sample_rate_hz);
    prepared_hz_ = sample_rate_hz;
    setLatency(static_cast<std::uint32_t>(renderer_->latency_samples()));
    for (const std::string& missing : renderer_->left_out()) {
      d_stderr2("Earpoint: the first model plays instead: %s", missing.c_str());
    }
    if (!renderer_->problem().empty()) {
      d_stderr2("Earpoint: the sound passes unchanged: %s", renderer_->problem().c_str());
    }
    values_[kStatus] = static_cast<float>(renderer_->status());
  }

  [[nodiscard]] double value(ParameterId id) const {
    return values_[id].load(std::memory_order_relaxed);
  }
  [[nodiscard]] bool is_on(ParameterId id) const { return value(id) > 0.5; }
  [[nodiscard]] Vector3 position(ParameterId x, ParameterId y, ParameterId z) const {
    return {value(x), value(y), value(z)};
  }

  [[nodiscard]] Settings settings() const {
    Settings settings;
    settings.earpoint = {position(kEarpointX, kEarpointY, kEarpointZ),
                         quaternion_from_euler({.yaw_rad = radians_from_degrees(value(kYaw)),
                                                .pitch_rad = radians_from_degrees(value(kPitch))})};
    if (is_on(kSpeakerGiven)) settings.speaker_m = position(kSpeakerX, kSpeakerY, kSpeakerZ);
    settings.model = static_cast<int>(std::lround(value(kModel)));
    settings.natural_texture = is_on(kNaturalTexture);
    settings.bypass = is_on(kBypass);
    return settings;
  }

  /// Hosts set them from any thread.
  std::array<std::atomic<float>, kParameterCount> values_{};
  std::unique_ptr<LiveRenderer> renderer_;  // null before activate()
  double prepared_hz_ = 0.0;
};

}  // namespace
}  // namespace earpoint::plugin

START_NAMESPACE_DISTRHO

// NOLINTNEXTLINE(readability-identifier-naming): DPF calls it so.
Plugin* createPlugin() { return new earpoint::plugin::EarpointPlugin(); }

END_NAMESPACE_DISTRHO
