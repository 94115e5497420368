#include <earpoint/study/simulated_participant.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <httplib.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::array<SimulatedRule, 3> kRules{SimulatedRule::mag, SimulatedRule::level,
                                              SimulatedRule::random};

/// Decodes a sound file's bytes.
Waveform decoded(const std::string& bytes) {
  static std::atomic<int> count = 0;
  const fs::path path =
      fs::temp_directory_path() / fmt::format("earpoint-heard-{}-{}.wav", ::getpid(), ++count);
  write_file(path, std::string_view(bytes));
  Waveform sound = read_sound(path);
  fs::remove(path);
  return sound;
}

double energy(std::span<const float> samples) {
  double sum = 1e-12;
  for (const float x : samples) sum += static_cast<double>(x) * x;
  return sum;
}

double level_difference_db(const Waveform& a, const Waveform& b) {
  double sum = 0.0;
  for (int ear = 0; ear < 2; ++ear) {
    sum += std::abs(10.0 * std::log10(energy(a.channel(ear)) / energy(b.channel(ear))));
  }
  return sum;
}

class SimulatedParticipant {
 public:
  SimulatedParticipant(int port, const SimulatedOptions& options)
      : options_(options), client_("127.0.0.1", port), random_(options.seed) {}

  SimulatedOutcome run() {
    const json joined =
        post("/api/participants",
             {{"label", options_.label}, {"simulated", std::string(name_of(options_.rule))}});
    SimulatedOutcome outcome{.participant = joined.at("participant")};
    const std::string self = "/api/participants/" + outcome.participant;
    const json state = json::parse(get(self));
    for (std::size_t i = 0; i < state.at("steps").size(); ++i) {
      const json told = post(fmt::format("{}/steps/{}", self, i),
                             answer(state.at("steps")[i], fmt::format("{}/steps/{}", self, i)));
      ++outcome.answers;
      outcome.passed_headphones = told.at("passed_headphones");
      if (!outcome.passed_headphones) return outcome;
    }
    post(self + "/finish", {{"comment", "simulated"}});
    return outcome;
  }

 private:
  json answer(const json& step, const std::string& place) {
    json result{{"revision", 0}, {"seconds", 0.0}};
    if (step.at("kind") == "headphones") {
      result["choice"] = quietest(decoded(get(place + "/sounds/0")));
      return result;
    }
    const Waveform reference = decoded(get(place + "/sounds/reference"));
    std::vector<double> differences;
    for (std::size_t i = 0; i < step.at("sounds"); ++i) {
      differences.push_back(
          difference(reference, decoded(get(fmt::format("{}/sounds/{}", place, i)))));
    }
    if (step.at("scale") == "") {
      result["choice"] = std::ranges::min_element(differences) - differences.begin();
      return result;
    }
    const double most = std::max(*std::ranges::max_element(differences), 1e-9);
    result["ratings"] = json::array();
    for (const double d : differences) result["ratings"].push_back(100.0 * (1.0 - d / most));
    return result;
  }

  double difference(const Waveform& reference, const Waveform& sound) {
    switch (options_.rule) {
      case SimulatedRule::mag:
        return binaural_metrics(reference, sound).mag;
      case SimulatedRule::level:
        return level_difference_db(reference, sound);
      case SimulatedRule::random:
        return random_.uniform();
    }
    return 0.0;
  }

  /// Of the three thirds of a sound.
  [[nodiscard]] std::ptrdiff_t quietest(const Waveform& sound) const {
    std::array<double, 3> energies{};
    for (int third = 0; third < 3; ++third) {
      const std::ptrdiff_t length = sound.samples() / 3;
      for (std::ptrdiff_t i = third * length; i < (third + 1) * length; ++i) {
        const double left = sound.channel(0)[i];
        const double heard = options_.has_loudspeakers ? 0.5 * (left + sound.channel(1)[i]) : left;
        energies[third] += heard * heard;
      }
    }
    return std::ranges::min_element(energies) - energies.begin();
  }

  std::string get(const std::string& path) {
    const httplib::Result answer = client_.Get(path);
    return checked(answer, path);
  }
  json post(const std::string& path, const json& body) {
    const httplib::Result answer = client_.Post(path, body.dump(), "application/json");
    return json::parse(checked(answer, path));
  }
  static std::string checked(const httplib::Result& answer, const std::string& path) {
    if (!answer) throw InputError(path, "the study's server does not answer");
    if (answer->status != 200) throw InputError(path, answer->body);
    return answer->body;
  }

  const SimulatedOptions& options_;
  httplib::Client client_;
  RandomStream random_;
};

}  // namespace

std::string_view name_of(SimulatedRule rule) {
  switch (rule) {
    case SimulatedRule::mag:
      return "mag";
    case SimulatedRule::level:
      return "level";
    case SimulatedRule::random:
      return "random";
  }
  return "";
}

SimulatedRule simulated_rule_named(std::string_view name) {
  for (const SimulatedRule rule : kRules) {
    if (name == name_of(rule)) return rule;
  }
  throw InputError("rule", fmt::format("expected mag, level or random, found '{}'", name));
}

SimulatedOutcome take_part(int port, const SimulatedOptions& options) {
  return SimulatedParticipant(port, options).run();
}

}  // namespace earpoint
